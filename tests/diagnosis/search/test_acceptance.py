"""The tests that a cause must stand, and the causes that lose their worth once another is there."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from support.plain_models import SAMPLES, plain_data, plain_model, plain_segment
from support.small_bench import AXIS, QUICK, STRIBECK, TRUTH, begun, idle_then_stribeck, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refit import RefitOptions, refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended
from robotid.diagnosis.scoring.blocked_regression import Gain
from robotid.diagnosis.search import acceptance
from robotid.diagnosis.search.acceptance import (
    Step,
    Steps,
    accept_best,
    accept_from_the_start,
    accept_pair,
    drop_worthless,
    objection,
)
from robotid.diagnosis.search.refits import CandidateRefit, RefitRound
from robotid.diagnosis.search.state import AcceptedCause, SearchState
from robotid.errors import NumericsError
from robotid.model.array import Array

ONE_STEP = RefitOptions(max_iterations=1)


def stribeck_step() -> Step:
    state, idle, both = idle_then_stribeck()
    return Step(state.first, idle, both, state.data)


def test_a_cause_that_loses_its_worth_is_dropped() -> None:
    state, idle, both = idle_then_stribeck()
    causes = (
        AcceptedCause("motor.cogging", 0.3, 1.0, 1e-9, ("motor.cogging",), state.first, idle, None),
        AcceptedCause("motor.stribeck", 0.9, 1.0, 1e-9, ("motor.stribeck",), idle, both, None),
    )
    after = drop_worthless(replace(state, model=both, causes=causes), QUICK, lambda _: None)
    assert [one.effect for one in after.causes] == ["motor.stribeck"]
    assert after.model.structure.effects == (*AXIS.effects, "motor.stribeck")
    (rejected,) = after.rejected
    assert (rejected.effect, rejected.explained) == ("motor.cogging", 0.3)
    assert rejected.why == "lost its worth once motor.stribeck was there"


def test_a_cause_must_be_worth_what_is_asked_on_the_records_held_out() -> None:
    step = stribeck_step()
    gained = (step.before.validation_energy - step.after.validation_energy) / step.data.validation_samples
    assert objection(step, replace(QUICK, min_improvement_sigma=0.99 * gained**0.5)) is None
    why = objection(step, replace(QUICK, min_improvement_sigma=1.01 * gained**0.5))
    assert why is not None
    assert "is not worth it" in why


def test_a_cause_that_moves_little_and_explains_a_thousandth_is_an_error_of_the_simulation() -> None:
    step = stribeck_step()
    wild = replace(step.first, fitted=tuple(replace(one, residual=100.0 * one.residual) for one in step.first.fitted))
    far = (replace(one, record=replace(one.record, dphi_m=1e3 * one.record.dphi_m)) for one in step.after.fitted)
    assert objection(step, QUICK) is None
    assert objection(replace(step, first=wild), QUICK) is None
    moving = replace(step, after=replace(step.after, fitted=tuple(far)))
    assert objection(moving, QUICK) is None
    assert "of the misfit" in str(objection(replace(moving, first=wild), QUICK))


def test_a_cause_with_which_the_joint_runs_away_cannot_be_told_from_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    def runs_away(_: RefittedModel) -> None:
        raise NumericsError("the joint runs away")

    monkeypatch.setattr("robotid.diagnosis.search.step.left_by", runs_away)
    why = acceptance.is_noise(stribeck_step(), Criteria())
    assert why == "cannot be distinguished from noise: the joint runs away"


def test_what_may_be_noise_by_chance_alone_is_not_distinguished(monkeypatch: pytest.MonkeyPatch) -> None:
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    scores = {one.candidate.name: one for one in state.round.best_of_each}
    score, other = scores["motor.stribeck"], scores["motor.quadratic_friction"]
    structure, start = extended(state.first, "motor.stribeck", STRIBECK)
    model = refit(structure, [start], state.data, state.first.trajectories)
    refits = [CandidateRefit(other, model), CandidateRefit(score, replace(model))]
    test = partial(_rejected_alone, model, "may be")
    monkeypatch.setattr(acceptance, "OBJECTIONS", (test,))
    for by_chance, twins in (((test,), ("motor.stribeck", "motor.quadratic_friction")), ((), ("motor.stribeck",))):
        monkeypatch.setattr(acceptance, "BY_CHANCE", by_chance)
        (cause,) = accept_best(state, refits, Steps(state), QUICK).causes
        assert cause.twins == twins


@pytest.mark.parametrize(("held_out", "first"), [(0.99, "motor.constant_torque"), (1.01, "motor.geared_gravity")])
def test_of_what_is_alike_the_simplest_that_carries_over_no_worse_goes_first(
    held_out: float, first: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    offset = {"motor.constant_torque.tau0": 0.03}
    state, refits = begun(records(offset), QUICK).scored(QUICK), []
    scores = {one.candidate.name: one for one in state.round.best_of_each}
    energy = state.first.validation_energy
    for name, values, share in (("geared_gravity", {}, 1.0), ("constant_torque", offset, held_out)):
        structure, start = extended(state.first, f"motor.{name}", values)
        model = refit(structure, [start], state.data, state.first.trajectories)
        (checked,) = model.validation
        model = replace(model, validation=(replace(checked, energy=share * energy),))
        refits.append(CandidateRefit(scores[f"motor.{name}"], model))
    monkeypatch.setattr(acceptance, "OBJECTIONS", ())
    (cause,) = accept_best(state, refits, Steps(state), QUICK).causes
    assert cause.effect == first
    assert {"motor.constant_torque", "motor.geared_gravity"} <= set(cause.twins)


def test_a_gain_that_may_be_chance_is_doubted_unless_the_records_held_out_are_simulated_worse() -> None:
    state, idle, both = idle_then_stribeck()
    accepted = Step(state.first, idle, both, state.data)
    unproven = Gain(np.array([1.0, -0.5, 2.0]), 0.2)
    for energy, doubted in ((0.9, True), (1.1, False)):
        after = replace(both, validation=tuple(replace(one, energy=energy * one.energy) for one in both.validation))
        one = Step(state.first, idle, after, replace(state.data, validation=()))
        one.__dict__["left_out"] = unproven
        assert acceptance.gains_by_chance(one, QUICK) is not None
        assert acceptance._is_doubted(one, accepted, QUICK) == doubted


def test_blocks_of_time_tell_two_causes_apart_where_the_better_leaves_more_than_noise() -> None:
    state = replace(
        begun(records(STRIBECK), QUICK).scored(QUICK), model=plain_model(1e5), data=plain_data(validation=False)
    )
    once, throughout = np.zeros(SAMPLES), np.ones(SAMPLES)
    once[: SAMPLES // 20] = 20.0

    def leaves(a_sample: float, more: Array) -> RefittedModel:
        waves = 1.0 + 0.1 * np.sin(np.arange(SAMPLES) + more[0])
        residual = np.sqrt(a_sample) * waves * np.sqrt(1.0 + more * (4000.0 / SAMPLES) / a_sample)
        left = replace(plain_segment(1.0), residual=residual, energy=float(residual @ residual))
        return plain_model(1.0, fitted=(left,), validation=())

    def are_alike(a_sample: float, more: Array) -> bool:
        best, other = leaves(a_sample, np.zeros(SAMPLES)), leaves(a_sample, more)
        assert 0.03 < (other.energy - best.energy) / (state.model.energy - best.energy) < 0.06
        return acceptance._are_alike(best, other, state, QUICK)

    assert are_alike(20.0, once)  # one moment decides, and what is left may be anything
    assert not are_alike(20.0, throughout)
    assert not are_alike(0.9, once)  # beside no more than the noise one moment is enough


def _rejected_alone(model: RefittedModel, why: str, step: Step, _: Criteria) -> str | None:
    return why if step.after is model else None


def test_a_cause_is_found_from_where_the_fit_started_when_the_fit_has_led_astray() -> None:
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    (score,) = [one for one in state.round.best_of_each if one.candidate.name == "motor.stribeck"]
    structure, start = extended(state.first, "motor.stribeck", STRIBECK)
    astray = CandidateRefit(score, refit(structure, [start], state.data, state.first.trajectories, ONE_STEP))
    (found,) = accept_from_the_start(state, [astray], Steps(state), QUICK, lambda _: None).causes
    assert found.effect == "motor.stribeck"
    assert found.after.parameters["motor.stribeck.dFs"] == pytest.approx(0.15, rel=0.05)
    unknown = replace(state, start={})
    assert accept_from_the_start(unknown, [astray], Steps(unknown), QUICK, lambda _: None) is unknown
    nowhere = replace(state, start={name: 1e3 * value for name, value in TRUTH.items()})
    assert accept_from_the_start(nowhere, [astray], Steps(nowhere), QUICK, lambda _: None) is nowhere


def test_the_first_of_a_pair_remembers_beside_what_it_carries_over(monkeypatch: pytest.MonkeyPatch) -> None:
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    structure, start = extended(state.first, "motor.stribeck", STRIBECK)
    model = refit(structure, [start], state.data, state.first.trajectories)

    def refitted(seen: SearchState, effect: str) -> CandidateRefit:
        (score,) = [one for one in seen.round.best_of_each if one.candidate.name == effect]
        return CandidateRefit(score, model)

    monkeypatch.setattr(acceptance, "refit_hopeful", lambda seen, *_: RefitRound((refitted(seen, "motor.cogging"),)))
    monkeypatch.setattr(acceptance, "OBJECTIONS", ())
    found = accept_pair(state, [refitted(state, "motor.stribeck")], Steps(state), QUICK, lambda _: None)
    assert [(one.effect, one.beside) for one in found.causes] == [
        ("motor.stribeck", "motor.cogging"),
        ("motor.cogging", ""),
    ]


@pytest.mark.parametrize(("size", "tried"), [(0.15, True), (0.02, False)])
def test_what_may_be_noise_is_fitted_once_more_only_where_the_misfit_is_large(size: float, tried: bool) -> None:
    """Beside a large misfit, a refit that lost its way leaves what any noise may be taken for."""
    hidden = STRIBECK | {"motor.stribeck.dFs": size}
    state = begun(records(hidden), QUICK).scored(QUICK)
    (score,) = [one for one in state.round.best_of_each if one.candidate.name == "motor.stribeck"]
    structure, start = extended(state.first, "motor.stribeck", hidden)
    one, said = CandidateRefit(score, refit(structure, [start], state.data, state.first.trajectories)), list[str]()
    assert accept_from_the_start(state, [one], Steps(state), replace(QUICK, significance=0.0), said.append) is state
    assert bool(said) is tried


def test_what_stands_every_test_but_that_of_sense_imitates_what_is_missing() -> None:
    """No gearbox warms up in a second; but whatever fades so is no noise either."""
    fading = {"motor.thermal_friction.c": 0.4, "motor.thermal_friction.T": 1.0}
    state = begun(records(fading), QUICK).scored(QUICK)
    score = next(one for one in state.round.scores if one.candidate.name == "motor.thermal_friction")
    structure, start = extended(state.first, "motor.thermal_friction", fading)
    refits = [CandidateRefit(score, refit(structure, [start], state.data))]
    after = accept_best(state, refits, Steps(state), QUICK)
    assert after.causes == ()
    assert after.rejected[0].why.startswith("makes no sense")
    assert after.rejected[0].imitates


@pytest.mark.parametrize(("share", "imitates"), [(0.6, True), (0.8, False)])
def test_what_makes_no_sense_and_explains_clearly_more_than_a_cause_imitates_what_is_missing(
    share: float, imitates: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """share : that the cause explains, of what the other does."""
    state, idle, both = idle_then_stribeck()
    state = state.scored(QUICK)
    first, second = (s for s in state.round.best_of_each if s.candidate.name in {"motor.stribeck", "motor.cogging"})
    refits = [CandidateRefit(first, both), CandidateRefit(second, idle)]
    monkeypatch.setattr(Step, "share", property(lambda step: 0.9 if step.after is both else 0.9 * share))
    monkeypatch.setattr(acceptance, "objection", lambda step, _: "makes no sense" if step.after is both else None)
    monkeypatch.setattr(acceptance, "_is_only_senseless", lambda step, _: step.after is both)
    monkeypatch.setattr(acceptance, "_is_doubted", lambda *_: False)
    after = accept_best(state, refits, Steps(state), QUICK)
    assert [cause.effect for cause in after.causes] == [second.candidate.name]
    assert after.rejected[0].imitates is imitates


def test_what_fails_another_test_imitates_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(acceptance, "OBJECTIONS", (lambda *_: "no", acceptance.is_not_physical))
    monkeypatch.setattr(acceptance, "is_not_physical", lambda *_: "makes no sense")
    state, _, both = idle_then_stribeck()
    state = state.scored(QUICK)
    one = CandidateRefit(state.round.scores[0], both)
    assert not accept_best(state, [one], Steps(state), QUICK).rejected[0].imitates
