"""The effect that the torque asks for along the measured motion, where a fit without it has gone astray."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest
from support.small_bench import QUICK, TRUTH, begun, evidence, records

from robotid.diagnosis.refit.refit import AS_IT_IS, refit
from robotid.diagnosis.search.data import first_state
from robotid.diagnosis.search.refits import RefitRound
from robotid.diagnosis.search.regression import asked_for
from robotid.diagnosis.search.search import add_cause
from robotid.diagnosis.search.state import SearchState
from robotid.estimate.fitted_model import simulate_record

GRAVITY = {"motor.gravity.G": 0.4, "motor.gravity.H": 0.0}
ASTRAY = {"motor.inertia.J": 0.6, "motor.viscous.Fv": 8.0, "motor.coulomb.Fc": 0.2}
"""Factors on the truth."""


def astray(hidden: Mapping[str, float] = GRAVITY) -> SearchState:
    """A search that begins with a model which simulates another motion."""
    state = begun(records(hidden), QUICK)
    values = {name: factor * TRUTH[name] for name, factor in ASTRAY.items()}
    first = refit(state.first.structure, [state.first.parameters.with_values(values)], state.data, options=AS_IT_IS)
    return replace(state, first=first).with_model(first, QUICK).scored(QUICK)


def test_a_model_that_goes_astray_still_gets_what_the_torque_asks_for(monkeypatch: pytest.MonkeyPatch) -> None:
    state = astray()
    found, *alike = asked_for(state, QUICK)
    assert found.effect == "motor.gravity"
    assert found.model.parameters["motor.gravity.G"] == pytest.approx(0.4, rel=0.05)
    assert found.model.parameters["motor.inertia.J"] == pytest.approx(TRUTH["motor.inertia.J"], rel=0.02)
    monkeypatch.setattr("robotid.diagnosis.search.search.refit_hopeful", lambda *_: RefitRound())
    (cause,) = add_cause(state, QUICK, lambda _: None).causes
    assert cause.effect == "motor.gravity"
    assert {one.effect for one in alike} <= set(cause.twins)  # a cogging of one period a turn is the same law


def test_a_fit_in_pieces_has_the_torque_of_whole_records_regressed() -> None:
    made = records(GRAVITY)
    by_wholes = evidence(made)
    fitted = [simulate_record(by_wholes.model, one, 0.1) for one in made[:2]]
    state = first_state(replace(by_wholes, fitted=fitted, horizon=0.1), QUICK).scored(QUICK)
    assert len(state.model.fitted) == 80
    assert [len(one) for one in state.recorded] == [len(one) for one in made[:2]]
    found = asked_for(state, QUICK)[0]
    assert found.effect == "motor.gravity"
    assert found.model.parameters["motor.gravity.G"] == pytest.approx(0.4, rel=0.05)


def test_a_torque_that_is_explained_asks_for_nothing() -> None:
    assert asked_for(begun(records({}), QUICK).scored(QUICK), QUICK) == []


def test_periods_between_those_of_the_grid_are_read_off_the_torque() -> None:
    """A simulation that goes astray loses the phase of a cogging; along the measured motion the torque keeps it."""
    state = astray({"motor.cogging.A": 0.3, "motor.cogging.B": 0.2, "motor.cogging.n": 45.3})
    shown = [
        replace(one, candidate=one.candidate.at(2, 48.0)) for one in state.round.best_of_each if one.candidate.repeats
    ]
    blind = replace(state, rounds=(replace(state.round, scores=tuple(shown)),))
    found = asked_for(blind, QUICK)[0]
    assert found.effect == "motor.cogging"
    assert found.model.parameters["motor.cogging.n"] == pytest.approx(45.3, rel=0.01)
