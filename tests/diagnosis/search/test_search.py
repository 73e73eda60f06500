"""What a search finds on a small axis: effects that were hidden there, one question a test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.small_bench import AXIS, SPEED_NOISE, TRUTH, begun, fitted, records, records_of, searched, simulated

from robotid.catalogue import assemble
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.nonparametric.curve_fit import fit_curves
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended
from robotid.diagnosis.results import Diagnosis
from robotid.diagnosis.scoring.candidate import Candidate
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search import refits
from robotid.diagnosis.search import search as searching
from robotid.diagnosis.search.acceptance import Step, drop_worthless, objection
from robotid.diagnosis.search.refits import CandidateRefit, refit_hopeful
from robotid.diagnosis.search.state import AcceptedCause, SearchResult, SearchState, misfit_energy
from robotid.diagnosis.verdict import verdict
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import fitted_model
from robotid.signals.record import Record

STRIBECK = {"motor.stribeck.dFs": 0.15, "motor.stribeck.vs": 1.0}
COGGING = {"motor.cogging.A": 0.04, "motor.cogging.B": 0.03, "motor.cogging.n": 6.0}
QUICK = Criteria(skip=("power_friction",))
"""Without the slowest refit, where it decides nothing."""


def told(made: list[Record], growth: SearchResult) -> Diagnosis:
    return verdict(fitted_model(fitted(made)), simulated(made), growth)


def only_in_the_fit() -> list[Record]:
    """A drift of the torque on the day of the fit, gone on the day of the check."""
    return [*records({"motor.constant_torque.tau0": 0.01})[:2], records({})[2]]


@cache
def question(name: str) -> tuple[list[Record], SearchResult, Diagnosis]:
    """Records, what the search finds on them, and the verdict; each asked once."""
    made = {
        "clean": lambda: records({}),
        "stribeck": lambda: records(STRIBECK),
        "pair": lambda: records(COGGING | STRIBECK),
        "warm": lambda: records({}, changed={"motor.coulomb.Fc": 1.1}),
        "accident": only_in_the_fit,
    }[name]()
    criteria = replace(QUICK, skip=("power_friction", "record_change")) if name == "pair" else QUICK
    growth = searched(made, criteria)
    return made, growth, told(made, growth)


def values(growth: SearchResult) -> dict[str, float]:
    """Of the last model, by name."""
    return dict(zip(growth.last.parameters.names, growth.last.parameters.values.tolist(), strict=True))


def test_nothing_is_named_where_nothing_is_missing() -> None:
    _, growth, d = question("clean")
    assert (d.verdict, d.causes, d.shape) == ("clean", (), None)
    assert growth.changes == ()
    assert d.misfit < 0.5 * d.noise_floor
    assert d.remaining == d.misfit
    assert {m.explained_after for m in d.records.values()} == {0.0}
    assert all(r.explained < 0.3 for r in d.rejected)
    # the noise of the torque adds to that of the speed, and a floor is an estimate
    assert d.noise_floor == pytest.approx(SPEED_NOISE, rel=0.3)


@pytest.mark.parametrize("seed", [2, 3])
def test_nothing_is_named_under_other_noise(seed: int) -> None:
    growth = searched(records({}, seed=seed), QUICK)
    assert (growth.causes, growth.curve, growth.changes) == ((), None, ())


def test_a_hidden_stribeck_effect_is_named_with_its_amplitude() -> None:
    _, growth, d = question("stribeck")
    assert (d.verdict, [c.effect for c in d.causes]) == ("named", ["motor.stribeck"])
    (cause,) = d.causes
    estimates = {p.name: p for p in cause.parameters}
    for name, truth in STRIBECK.items():
        assert abs(estimates[name].value - truth) < 4 * estimates[name].std
        assert estimates[name].std < 0.1 * truth
    assert cause.explained > 0.95
    assert cause.p_value < 1e-9
    assert d.remaining < 0.2 * d.misfit
    assert values(growth)["motor.coulomb.Fc"] == pytest.approx(0.6, rel=0.01)


def test_the_gain_that_a_cause_claims_is_that_of_its_held_out_record() -> None:
    _, growth, _ = question("stribeck")
    (found,) = growth.causes
    assert found.gain == pytest.approx(found.after.validation_fit_percent - found.before.validation_fit_percent)
    assert found.gain > 1.0
    assert found.after.validation_energy < 1.2 * growth.data.validation_samples


def test_both_effects_of_a_pair_are_named() -> None:
    _, growth, d = question("pair")
    named = {effect for cause in d.causes for effect in cause.twins}
    assert {"motor.cogging", "motor.stribeck"} <= named
    assert d.verdict == "named"
    found = values(growth)
    assert np.hypot(found["motor.cogging.A"], found["motor.cogging.B"]) == pytest.approx(0.05, rel=0.1)
    assert found["motor.stribeck.dFs"] == pytest.approx(0.15, rel=0.1)


def test_what_causes_explain_adds_up_to_what_they_leave() -> None:
    """Though the noise is taken for smaller from cause to cause."""
    _, growth, d = question("pair")
    left, whole = (misfit_energy(model, growth.data) for model in (growth.last, growth.first))
    assert len(d.causes) > 1
    assert growth.data.fitted[0].whitening.output != pytest.approx(growth.first.fitted[0].whitening.output, rel=0.01)
    assert sum(cause.explained for cause in d.causes) == pytest.approx(1 - left / whole, abs=1e-3)


def test_what_differs_in_one_fitted_record_is_named_with_its_size() -> None:
    """Warmer in the slow record by a tenth of the friction; which of two records is the odd one, none can tell."""
    _, growth, d = question("warm")
    first = d.causes[0]
    slow, wide = (f"record_change.{name}.motor.coulomb.Fc" for name in ("slow", "wide"))
    assert first.effect in (slow, wide)
    assert {slow, wide} <= set(first.twins)
    (estimate,) = first.parameters
    assert estimate.value == pytest.approx(0.06 if first.effect == slow else -0.06, rel=0.05)
    assert (estimate.unit, d.verdict) == ("Nm", "named")
    assert growth.causes[0].explained > 0.95


def test_an_accident_of_the_fitted_records_does_not_carry_over() -> None:
    _, growth, d = question("accident")
    assert "motor.constant_torque" not in {effect for cause in d.causes for effect in cause.twins}
    rejected = {one.effect: one for one in growth.rejected}
    one = rejected["motor.constant_torque"]
    assert one.why.startswith("does not carry over")
    assert one.gain < 0.0
    assert one.explained > 0.5
    assert ("motor.constant_torque", one.why) in {(r.effect, r.why) for r in d.rejected}


def test_a_misfit_far_above_the_noise_is_not_called_clean() -> None:
    """Nothing is named there, and no shape stands; it is a misfit all the same."""
    made, growth, _ = question("accident")
    bare = replace(growth, causes=(), changes=(), curve=None, last=growth.first)
    d = told(made, bare)
    assert d.misfit > 2 * d.noise_floor
    assert d.verdict == "unknown"
    assert any("far above the noise" in remark for remark in d.remarks)
    assert not any(r.why == "there is nothing to explain" for r in d.rejected)


def test_what_is_skipped_is_not_scored() -> None:
    _, growth, _ = question("clean")
    scored = {s.candidate.name for r in growth.rounds for s in r.scores}
    assert "motor.power_friction" not in scored
    assert {"motor.stribeck", "motor.presliding", "torque.torque_delay", "angle.encoder_ripple"} <= scored
    assert any(name.startswith("record_change.") for name in scored)


def test_every_rejection_tells_why_and_none_is_a_cause() -> None:
    for name in ("clean", "stribeck", "accident"):
        _, _, d = question(name)
        names = [r.effect for r in d.rejected]
        assert len(names) == len(set(names))
        assert not set(names) & {effect for cause in d.causes for effect in cause.twins}
        assert all(r.why for r in d.rejected)


def refit_but(
    monkeypatch: pytest.MonkeyPatch, refused: Callable[[Round, Candidate], bool]
) -> tuple[Round, list[CandidateRefit]]:
    """A round, and what is refitted of it where some refits fail; no candidate is asked for twice."""
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    refitted, asked = refits._refitted, list[Candidate]()

    def failing(state: SearchState, one: Score, explained: float) -> RefittedModel:
        asked.append(one.candidate)
        if refused(state.round, one.candidate):
            raise NumericsError("not this one")
        return refitted(state, one, explained)

    monkeypatch.setattr(refits, "_refitted", failing)
    tried = refits.refit_hopeful(state, QUICK, lambda _: None)
    assert len(set(asked)) == len(asked)
    return state.round, tried


def hopeful(seen: Round) -> set[str]:
    return {one.candidate.name for one in seen.best_of_each if one.energy > 0.5 * seen.scores[0].energy}


def test_candidates_that_cannot_be_refitted_give_way_to_those_that_follow(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, tried = refit_but(monkeypatch, lambda seen, one: one.name in hopeful(seen))
    assert tried
    assert not {one.effect for one in tried} & hopeful(seen)


def test_an_effect_that_cannot_be_refitted_from_one_point_of_its_grid_is_tried_from_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(seen: Round, one: Candidate) -> bool:
        best = seen.scores[0].candidate
        return one.name != best.name or one == best

    seen, tried = refit_but(monkeypatch, refused)
    best = seen.scores[0].candidate
    assert [one.effect for one in tried] == [best.name]
    assert tried[0].score.candidate != best


def test_what_differs_on_a_record_held_out_is_told_with_its_size() -> None:
    warm = records_of(assemble(AXIS, angle=True), TRUTH | {"motor.coulomb.Fc": 0.7})[2]
    made = [*records({})[:2], warm]
    growth = searched(made, QUICK)
    (one,) = growth.changes
    assert growth.causes == ()
    assert one.effect == "record_change.check.motor.coulomb.Fc"
    assert one.value == pytest.approx(0.1, rel=0.1)
    assert told(made, growth).verdict == "named"


@cache
def idle_then_stribeck() -> tuple[SearchState, RefittedModel, RefittedModel]:
    """The axis, with a cogging that it does not have, and with the Stribeck effect that it has besides."""
    state = begun(records(STRIBECK), QUICK)
    cogging = {f"motor.cogging.{k}": v for k, v in (("A", 0.01), ("n", 6.0))}
    structure, start = extended(state.first, "motor.cogging", cogging)
    idle = refit(structure, [start], state.data, state.first.trajectories)
    structure, start = extended(idle, "motor.stribeck", STRIBECK)
    return state, idle, refit(structure, [start], state.data, idle.trajectories)


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


def test_a_cause_that_explains_a_thousandth_is_an_error_of_the_simulation() -> None:
    step = stribeck_step()
    wild = replace(step.first, fitted=tuple(replace(one, residual=100.0 * one.residual) for one in step.first.fitted))
    assert objection(step, QUICK) is None
    assert "of the misfit" in str(objection(replace(step, first=wild), QUICK))


def test_only_what_is_significant_and_worth_it_is_refitted() -> None:
    loose = replace(QUICK, min_improvement_sigma=0.0)
    state = begun(records({}), loose).scored(loose)
    p = min(state.round.p_value(one) for one in state.round.scores)
    worth = (state.round.scores[0].energy / state.data.samples) ** 0.5

    def tried(level: float, worth: float = 0.0) -> list[CandidateRefit]:
        criteria = replace(loose, significance=level, min_improvement_sigma=worth)
        return refit_hopeful(state, criteria, lambda _: None)

    assert tried(2.0 * p)
    assert not tried(p)
    assert not tried(2.0 * p, 1.01 * worth)


@pytest.mark.parametrize(
    ("reached", "named", "shaped", "named_then", "passes"),
    [
        (True, False, False, True, 1),  # the sensors explain what is left: nothing is missing
        (False, True, False, True, 1),
        (False, False, False, False, 2),
        (False, False, True, True, 2),
    ],
)
def test_errors_of_the_torque_are_allowed_for_where_sensors_explain_too_little(
    reached: bool, named: bool, shaped: bool, named_then: bool, passes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, one, _ = question("stribeck")
    allowed, ended = list[bool](), list[SearchResult]()

    def first_state(*_: object, torque_errors: bool = False) -> SearchState:
        allowed.append(torque_errors)
        data = replace(one.data, noise_reached=reached, torque_errors=torque_errors)
        return replace(idle_then_stribeck()[0], data=data)

    def find_causes(state: SearchState, *_: object) -> SearchResult:
        curve = fit_curves(one.first, one.data)[0] if shaped and not state.data.torque_errors else None
        causes = one.causes if (named_then if state.data.torque_errors else named) else ()
        ended.append(replace(one, data=state.data, causes=causes, curve=curve))
        return ended[-1]

    monkeypatch.setattr(searching, "first_state", first_state)
    monkeypatch.setattr(searching, "find_causes", find_causes)
    assert searched(made, QUICK) is ended[-1]
    assert allowed == [False, True][:passes]


def test_a_curve_stands_where_errors_of_the_torque_leave_no_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    made, one, _ = question("stribeck")
    state = idle_then_stribeck()[0]
    first = replace(one, causes=(), curve=fit_curves(one.first, one.data)[0])
    both = iter([first, replace(one, causes=())])
    unreached = replace(state, data=replace(state.data, noise_reached=False))
    monkeypatch.setattr(searching, "first_state", lambda *_, **__: unreached)
    monkeypatch.setattr(searching, "find_causes", lambda *_: next(both))
    assert searched(made, QUICK) is first
