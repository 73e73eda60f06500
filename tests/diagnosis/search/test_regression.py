"""The effect that the torque asks for along the measured motion, where a fit without it has gone astray."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from support.small_bench import (
    AXIS,
    DURATION,
    QUICK,
    SAMPLING_TIME,
    TRUTH,
    begun,
    evidence,
    records,
    records_of,
)

from robotid.catalogue import assemble
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refit import AS_IT_IS, refit
from robotid.diagnosis.search.acceptance import accept_asked_for
from robotid.diagnosis.search.data import first_state
from robotid.diagnosis.search.refits import RefitRound
from robotid.diagnosis.search.regression import _regression, asked_for
from robotid.diagnosis.search.rounds import add_cause
from robotid.diagnosis.search.search import _asked_for_by_the_motion
from robotid.diagnosis.search.state import SearchState
from robotid.estimate.fitted_model import simulate_record
from robotid.estimate.rest import at_rest
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.record import Record

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
    monkeypatch.setattr("robotid.diagnosis.search.rounds.refit_hopeful", lambda *_: RefitRound())
    (cause,) = add_cause(state, QUICK, lambda _: None).causes
    assert cause.effect == "motor.gravity"
    assert {one.effect for one in alike} <= set(cause.twins)  # a cogging of one period a turn is the same law


def test_a_record_that_rests_all_the_time_takes_no_part() -> None:
    made = records({})[:2]
    still = replace(made[0], name="still", phi_m=0.0 * made[0].phi_m, dphi_m=0.0 * made[0].dphi_m)
    parameters = assemble(AXIS).parameters().with_values(TRUTH)
    with_it, without = (_regression(assemble(AXIS), parameters, some)[1] for some in ([*made, still], made))
    assert [one.name for one in with_it.parameters] == [one.name for one in without.parameters]
    for one, other in zip(with_it.parameters, without.parameters, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-6)


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


def test_a_torque_that_is_explained_asks_for_nothing_that_stands() -> None:
    """A cogging with any number of periods takes most of the little that a filter leaves, and a simulation refutes
    it."""
    state = begun(records({}), QUICK).scored(QUICK)
    assert {one.effect for one in asked_for(state, QUICK)} <= {"motor.cogging"}
    assert accept_asked_for(state, [], QUICK, lambda _: None).causes == ()


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


def test_bristles_that_bend_where_a_simulation_rests(monkeypatch: pytest.MonkeyPatch) -> None:
    """What dry friction holds moves for no torque: no column tells of bristles there, and what they leave passes for
    errors of the torque."""
    made = records({"motor.presliding.w": 1.0, "motor.presliding.s0": 2.0, "motor.presliding.s1": 0.0})
    monkeypatch.setattr("robotid.diagnosis.search.rounds.refit_hopeful", lambda *_: RefitRound())
    found = _asked_for_by_the_motion(evidence(made), QUICK, lambda _: None)
    assert found is not None
    assert [cause.effect for cause in found.causes] == ["motor.presliding"]
    assert found.last.parameters["motor.presliding.s0"] == pytest.approx(2.0, rel=0.02)
    assert found.last.parameters["motor.presliding.w"] > 0.98


def test_a_torque_that_is_explained_asks_for_no_other_search() -> None:
    assert _asked_for_by_the_motion(evidence(records({})), QUICK, lambda _: None) is None


def with_pauses(joint: Joint, truth: Mapping[str, float]) -> list[Record]:
    """Moves there and back, each after a pause in which dry friction carries what torque the controller has left."""
    t = np.arange(round(2 * DURATION / SAMPLING_TIME)) * SAMPLING_TIME

    def moves(speed: float, period: float) -> Array:
        wave = np.sin(2 * np.pi * t / period)
        return np.asarray(speed * np.sign(wave) * np.clip(10.0 * (np.abs(wave) - 0.4), 0.0, 1.0))

    wanted = {"slow": moves(3.0, 2.0), "wide": moves(12.0, 1.3), "check": moves(7.0, 1.6)}
    return records_of(joint, truth, wanted=wanted)


DRAGS_ONE_WAY = (
    assemble(AXIS.extended("motor.asymmetric_coulomb"), angle=True),
    TRUTH | {"motor.asymmetric_coulomb.dFc": 0.03},
)
WITHOUT_SLOWEST = Criteria(skip=("power_friction", "cogging", "position_friction"))


def test_what_dry_friction_carries_at_rest_hides_nothing_that_the_torque_asks_for() -> None:
    made = with_pauses(*DRAGS_ONE_WAY)
    assert np.mean([at_rest(one).mean() for one in made]) > 0.2
    found = asked_for(begun(made, WITHOUT_SLOWEST).scored(WITHOUT_SLOWEST), WITHOUT_SLOWEST)
    assert {"motor.asymmetric_coulomb", "motor.constant_torque"} <= {one.effect for one in found}
    assert max(abs(one.model.parameters.values[-1]) for one in found) == pytest.approx(0.03, rel=0.1)
