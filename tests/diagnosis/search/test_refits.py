"""Which candidates are refitted, and what follows where they cannot be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_bench import QUICK, STRIBECK, begun, idle_then_stribeck, records

from robotid.catalogue import reading
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.noise_estimate import TorqueErrors
from robotid.diagnosis.refit import refit as refitting
from robotid.diagnosis.refit.refit import NoBetter
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.scoring.candidate import Candidate
from robotid.diagnosis.scoring.catalogue_candidates import term_candidate
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search import refits
from robotid.diagnosis.search.acceptance import Steps, as_cause
from robotid.diagnosis.search.refits import (
    CandidateRefit,
    _attempt,
    _refit_directly,
    chosen_of,
    in_order,
    refit_hopeful,
)
from robotid.errors import NumericsError
from robotid.estimate.residual import OutputError
from robotid.model.port import Port
from robotid.terms import TERMS


def refit_but(
    monkeypatch: pytest.MonkeyPatch, refused: Callable[[Round, Candidate], bool]
) -> tuple[Round, list[CandidateRefit]]:
    """A round, and what is refitted of it where some refits fail; no candidate is asked for twice."""
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    directly, asked = refits._refit_directly, list[Candidate]()
    candidates = {score.energy: score.candidate for score in state.round.scores}

    def failing(around: refits.Around, one: refits._Attempt) -> RefittedModel | None:
        asked.append(candidates[one.promised])
        return None if refused(state.round, asked[-1]) else directly(around, one)

    monkeypatch.setattr(refits, "_refit_directly", failing)
    monkeypatch.setattr(refits, "_refit_by_pieces", lambda *_: None)
    tried = list(refits.refit_hopeful(state, QUICK, lambda _: None).refits)
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


def test_of_an_effect_that_leads_astray_no_further_point_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    wild = "motor.stribeck"
    points = [one for one in state.round.scores if one.candidate.name == wild][:3]
    other = next(one for one in state.round.scores if one.candidate.name != wild)
    directly, asked = refits._refit_directly, list[str]()

    def astray(around: refits.Around, one: refits._Attempt) -> RefittedModel | None:
        asked.append(next(name for name in one.structure.effects if name not in around[0].structure.effects))
        if asked[-1] == wild:
            raise NumericsError("it diverges")
        return directly(around, one)

    monkeypatch.setattr(refits, "_refit_directly", astray)
    monkeypatch.setattr(refits, "_refit_by_pieces", lambda *_: None)
    refits._refits([*points, other], state, lambda _: None)
    assert len(points) > 1
    assert asked == [wild, other.candidate.name]


def test_a_boldest_start_that_leads_astray_is_followed_by_the_most_cautious(monkeypatch: pytest.MonkeyPatch) -> None:
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    attempt = refits._attempt(state.round.scores[0], state)
    begin, begun_at = refitting._begin, list[float]()

    def astray(problem: OutputError, *rest: object, **options: object) -> object:
        begun_at.append(problem.parameters["motor.stribeck.dFs"])
        if len(begun_at) == 1:
            raise NumericsError("it diverges")
        return begin(problem, *rest, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(refitting, "_begin", astray)
    monkeypatch.setattr(refitting, "_by_fewer_samples", lambda *_: None)
    refitting.refit(attempt.structure, attempt.starts, state.data, state.model.trajectories)
    starts = [one["motor.stribeck.dFs"] for one in attempt.starts]
    assert begun_at[:2] == [starts[0], starts[-1]]


@pytest.mark.parametrize(("torque_errors", "again"), [(None, True), ("white", False), ("coloured", False)])
def test_a_refit_that_does_harm_elsewhere_has_lost_its_way_but_beside_errors_of_the_torque(
    monkeypatch: pytest.MonkeyPatch, torque_errors: TorqueErrors, again: bool
) -> None:
    state = begun(records(STRIBECK), QUICK).scored(QUICK)
    data = replace(state.data, torque_errors=torque_errors)
    one = refits._attempt(state.round.scores[0], state)
    after = refits._refit_directly((state.model, state.data), one)
    assert after is not None
    harmed = [replace(s, energy=s.energy + state.model.validation_energy) for s in after.validation]
    asked = list[object]()
    monkeypatch.setattr(refits, "_refit_by_pieces", lambda *work: asked.append(work))
    for end, tried in ((after, False), (replace(after, validation=tuple(harmed)), again)):
        asked.clear()
        assert refits._kept(end, one, replace(state, data=data), 0.0) is end
        assert bool(asked) == tried


def test_a_change_of_the_other_of_two_records_takes_no_place() -> None:
    """Both are one, but for the parameter that all records share."""
    effect = term_candidate(Port.MOTOR, TERMS["quadratic_friction"], (0.0,))

    def scored(name: str, column: int, energy: float) -> Score:
        return Score(replace(effect, name=name), energy, (1.0,), np.eye(4)[:, column : column + 1], np.zeros(4))

    first, other, third = (f"record_change.{record}.motor.coulomb.Fc" for record in "abc")
    names = [first, other, third, "motor.stribeck", "motor.cogging"]
    scores = [
        scored(name, column, 9.0 - k) for k, (name, column) in enumerate(zip(names, (0, 0, 1, 2, 3), strict=True))
    ]
    found = chosen_of(scores, Criteria(max_refits=3))
    assert [one.candidate.name for one in found] == [first, other, third, "motor.stribeck", "motor.cogging"]
    apart = [scored("motor.stribeck", 0, 9.0), scored("motor.cogging", 0, 8.0)]
    assert len(chosen_of(apart, Criteria(max_refits=1))) == 1


def test_only_what_is_significant_and_worth_it_is_refitted() -> None:
    loose = replace(QUICK, min_improvement_sigma=0.0)
    state = begun(records({}), loose).scored(loose)
    p = min(state.round.p_value(one) for one in state.round.scores)
    worth = (state.round.scores[0].energy / state.data.samples) ** 0.5

    def tried(level: float, worth: float = 0.0) -> list[CandidateRefit]:
        criteria = replace(loose, significance=level, min_improvement_sigma=worth)
        return list(refit_hopeful(state, criteria, lambda _: None).refits)

    assert tried(2.0 * p)
    assert not tried(p)
    assert not tried(2.0 * p, 1.01 * worth)


@dataclass(frozen=True)
class Stand:
    """What ordering asks of a refitted model."""

    energy: float
    validation_energy: float
    samples: int = 1000
    columns: tuple[int, ...] = (0, 1)


@dataclass(frozen=True)
class Kept:
    """What ordering asks of the data."""

    validation: tuple[int, ...]
    samples: int = 1000


def lever(psi: float, energy: float, validation_energy: float) -> CandidateRefit:
    candidate = term_candidate(Port.MOTOR, reading(TERMS["pose_lever"], "q2"), (0.0, psi))
    score = Score(candidate, energy, (1.0,), np.eye(3)[:, :1], np.zeros(3))
    return CandidateRefit(score, Stand(energy, validation_energy))  # type: ignore[arg-type]


@pytest.mark.parametrize(("validation", "psi"), [((1,), 0.0), ((), np.pi / 2)])
def test_of_several_laws_the_one_that_carries_over_stands_for_the_effect(
    validation: tuple[int, ...], psi: float
) -> None:
    """The cosine fits better, the sine leaves less of what was held out."""
    laws = [lever(np.pi / 2, 700.0, 4000.0), lever(0.0, 760.0, 1700.0)]
    (found,) = in_order(laws, before(1000.0, validation), Criteria())
    assert found.score.candidate.variant == (psi,)


def before(energy: float, validation: tuple[int, ...] = ()) -> Any:
    """What ordering asks of the state without any of the refits."""
    return SimpleNamespace(data=Kept(validation), model=SimpleNamespace(energy=energy))


@pytest.mark.parametrize(("energy", "first"), [(2000.0, "motor.quadratic_friction"), (1050.0, "motor.power_friction")])
def test_a_simpler_effect_goes_first_where_little_of_what_the_best_explains_is_lost(energy: float, first: str) -> None:
    """Of a misfit that is small beside the noise, the least improvement may be most of it."""

    def refitted(name: str, values: tuple[float, ...], left: float) -> CandidateRefit:
        score = Score(term_candidate(Port.MOTOR, TERMS[name], values), 1.0, (1.0,), np.eye(3)[:, :1], np.zeros(3))
        return CandidateRefit(score, Stand(left, 0.0, columns=(0,) * len(values)))  # type: ignore[arg-type]

    both = [refitted("quadratic_friction", (0.0,), 830.0), refitted("power_friction", (0.0, 0.5), 780.0)]
    assert in_order(both, before(energy), Criteria(min_improvement_sigma=0.3))[0].effect == first


def test_an_effect_is_refitted_on_either_side_of_what_it_does_as_another() -> None:
    """A power of one is viscous friction; no fit gets from a power above it to one below."""
    powers = [term_candidate(Port.MOTOR, TERMS["power_friction"], (0.0, alpha)) for alpha in (1.75, 1.5, 0.5)]
    scores = [Score(one, 10.0, (1.0,), np.eye(3)[:, :1], np.zeros(3)) for one in powers]
    assert [one.candidate.values[1] for one in refits._variants(scores[:1], scores)] == [0.5]


def test_an_effect_at_a_bound_stands_behind_the_simpler_ones_that_it_becomes() -> None:
    state = begun(records({"motor.constant_torque.tau0": 0.05}), QUICK).scored(QUICK)
    score = next(one for one in state.round.scores if one.candidate.name == "motor.geared_gravity")
    found = refits._refits([score], state, lambda _: None).refits
    ordered = [one.effect for one in refits.simpler_first(refits._with_extremes(found, state, lambda _: None), state)]
    assert ordered == ["motor.constant_torque", "motor.asymmetric_coulomb", "motor.geared_gravity"]
    assert refits.simpler_first(found, state) == list(found)


@pytest.mark.parametrize("leaves", [False, True])
def test_what_the_best_would_become_at_a_bound_is_tried_where_it_leaves_more_than_noise(
    monkeypatch: pytest.MonkeyPatch, *, leaves: bool
) -> None:
    """A refit may have ended at an imitation, short of the bound."""
    state = begun(records({"motor.constant_torque.tau0": 0.05}), QUICK).scored(QUICK)
    score = next(one for one in state.round.scores if one.candidate.name == "motor.geared_gravity")
    found = refits._refits([score], state, lambda _: None).refits
    monkeypatch.setattr(refits, "_is_at_bound", lambda *_: False)
    monkeypatch.setattr(refits, "leaves_something", lambda *_: leaves)
    _, *simpler = [one.effect for one in refits._with_extremes(found, state, lambda _: None)]
    assert simpler == leaves * ["motor.constant_torque", "motor.asymmetric_coulomb"]


@pytest.mark.parametrize(
    ("error", "unfollowed"),
    [(NumericsError("it settles too slowly"), "motor.asymmetric_coulomb"), (NoBetter("no"), None)],
)
def test_what_no_simulation_of_an_effect_at_a_bound_follows_is_kept_in_mind(
    error: NumericsError, unfollowed: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = begun(records({"motor.constant_torque.tau0": 0.05}), QUICK).scored(QUICK)
    score = next(one for one in state.round.scores if one.candidate.name == "motor.geared_gravity")
    found = refits._refits([score], state, lambda _: None).refits

    def fails(*_: object) -> RefittedModel:
        raise error

    monkeypatch.setattr(refits, "refit", fails)
    (left,) = refits._with_extremes(found, state, lambda _: None)
    assert (left.effect, left.unfollowed) == ("motor.geared_gravity", unfollowed)
    assert as_cause(state, [left], Steps(state).to(left), QUICK).unfollowed == unfollowed


@pytest.mark.parametrize(("left", "first"), [(900.0, "gear.backlash"), (1100.0, "gear.soft_spring")])
def test_a_simpler_law_that_carries_over_as_well_stands_before_the_one_that_becomes_it(
    left: float, first: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """left : on the records held out, where the soft spring leaves 1000."""
    state = begun(records({"motor.constant_torque.tau0": 0.05}), QUICK).scored(QUICK)
    held_out = state.model.validation

    def made(effect: str, energy: float, validation_energy: float) -> CandidateRefit:
        candidate = SimpleNamespace(name=effect)
        model = SimpleNamespace(energy=energy, validation_energy=validation_energy, validation=held_out)
        return CandidateRefit(SimpleNamespace(candidate=candidate), model)  # type: ignore[arg-type]

    monkeypatch.setattr(refits, "_is_at_bound", lambda *_: False)
    found = [made("gear.soft_spring", 0.1 * state.model.energy, 1000.0)]
    found.append(made("gear.backlash", 0.11 * state.model.energy, left))
    assert next(iter(refits.simpler_first(found, state))).effect == first


def test_an_effect_that_mostly_is_there_as_a_whole_is_refitted_from_there_too() -> None:
    """The first part of such a share changes the motion in another way than the last."""
    bristles = {"motor.presliding.w": 1.0, "motor.presliding.s0": 110.0, "motor.presliding.s1": 8e-4}
    state = begun(records(bristles), QUICK).scored(QUICK)
    best = {one.candidate.name: one for one in state.round.best_of_each}
    attempt = _attempt(best["motor.presliding"], state)
    assert attempt.whole is not None
    assert attempt.whole["motor.presliding.w"] == 1.0
    lost = replace(attempt, starts=attempt.starts[-1:])
    found = _refit_directly((state.model, state.data), lost)
    assert found is not None
    assert found.parameters["motor.presliding.w"] == pytest.approx(1.0, abs=0.1)
    assert found.parameters["motor.presliding.s0"] == pytest.approx(110.0, rel=0.2)
    assert _attempt(best["motor.cogging"], state).whole is None


def test_what_cannot_be_simulated_from_one_start_may_be_from_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    state, _, both = idle_then_stribeck()
    state = state.scored(QUICK)
    attempt = _attempt(state.round.scores[0], state)
    attempt = replace(attempt, whole=attempt.starts[-1])
    for failing, outcome in (((attempt.starts,), both), ((attempt.starts, (attempt.whole,)), None)):

        def refitted(_: Any, starts: Any, *__: Any, failing: Any = failing) -> RefittedModel:
            if starts in failing:
                raise NumericsError("it runs away")
            return both

        monkeypatch.setattr(refits, "refit", refitted)
        if outcome is None:
            with pytest.raises(NumericsError):
                _refit_directly((state.model, state.data), attempt)
        else:
            assert _refit_directly((state.model, state.data), attempt) is outcome
