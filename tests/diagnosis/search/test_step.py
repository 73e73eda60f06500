"""A step of the search: how a cause is confirmed on records that were held out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from support.plain_models import plain_model
from support.small_bench import QUICK, begun, idle_then_stribeck, records

from robotid.diagnosis.refit import refit as refitting
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended
from robotid.diagnosis.search.carry_over import proven
from robotid.diagnosis.search.coloured import Tried
from robotid.diagnosis.search.step import Step
from robotid.errors import NumericsError
from robotid.model.parameters import Parameters


def test_a_model_that_does_not_settle_on_records_held_out_is_not_simulated_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    state, idle, both = idle_then_stribeck()
    asked = []

    def unsettled(*arguments: Any) -> Any:
        asked.append(arguments[-1])
        if arguments[-1].max_failed_windows is not None:
            raise NumericsError("the simulation settles too slowly to be of use")
        return refit(*arguments)

    monkeypatch.setattr(refitting, "refit", unsettled)
    step = Step(state.first, idle, both, state.data)
    assert step.elsewhere is None
    assert [one.careful for one in asked] == [True, True]
    assert Step(state.first, idle, both, state.data).p_value < 1e-6  # by the records of the fit


def test_records_held_out_confirm_a_cause_from_nothing_or_from_what_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    state, idle, both = idle_then_stribeck()
    tried = list[Parameters]()
    energies = iter((3.0, 2.0, 2.0, 3.0))

    def refitted(_: object, starts: Sequence[Parameters], *__: object) -> RefittedModel:
        tried.extend(starts)
        return plain_model(next(energies))

    monkeypatch.setattr(refitting, "refit", refitted)
    for _ in range(2):
        found = Step(state.first, idle, both, state.data).elsewhere
        assert found is not None
        assert found.energy == 2.0
    assert [one["motor.stribeck.dFs"] for one in tried[:2]] == [0.0, both.parameters["motor.stribeck.dFs"]]


COGGING = {"motor.cogging.A": 0.03, "motor.cogging.B": -0.02, "motor.cogging.n": 12.0}


@pytest.mark.parametrize(("hidden", "there"), [(COGGING, True), ({}, False)])
def test_what_is_left_out_is_explained_in_the_shape_that_was_found(hidden: dict[str, float], there: bool) -> None:
    state = begun(records(hidden), QUICK)
    structure, start = extended(state.first, "motor.cogging", COGGING)
    after = refit(structure, [start], state.data, state.first.trajectories)
    gain = Step(state.first, state.first, after, state.data).left_out
    assert gain is not None
    assert (gain.p_value < 1e-6) is there
    assert proven(gain) is there


def test_what_has_no_amplitude_leaves_nothing_out() -> None:
    state, idle, _ = idle_then_stribeck()
    assert Step(state.first, idle, idle, state.data).left_out is None


def test_what_a_cause_gains_elsewhere_counts_with_what_the_fit_hints_at(monkeypatch: pytest.MonkeyPatch) -> None:
    state, idle, both = idle_then_stribeck()
    monkeypatch.setattr("robotid.diagnosis.search.step.p_value", lambda *_: 5e-3)
    one, many = (Step(state.first, idle, both, state.data, Tried(refits=count)) for count in (1, 10**9))
    assert proven(one.held_out)
    assert one.p_value < 1e-3
    assert many.p_value == 5e-3


def test_what_records_held_out_ask_for_by_themselves_does_not_count_with_their_gain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They would be heard twice."""
    state, idle, both = idle_then_stribeck()

    def of_few_blocks(*arguments: Any) -> float:
        return 1.0 if arguments[-1]() is None else 5e-3

    monkeypatch.setattr("robotid.diagnosis.search.step.p_value", of_few_blocks)
    monkeypatch.setattr(Step, "elsewhere", both)
    step = Step(state.first, idle, both, state.data)
    assert proven(step.held_out)
    assert step.p_value == 5e-3
