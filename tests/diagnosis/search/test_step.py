"""A step of the search: how a cause is confirmed on records that were held out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from support.plain_models import plain_model
from support.small_bench import idle_then_stribeck

from robotid.diagnosis.refit import refit as refitting
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel
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
