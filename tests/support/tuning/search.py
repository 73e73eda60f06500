"""Checks of the constants of the search."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.nonparametric.curve_fit import FittedCurve
from robotid.diagnosis.refit.refitted_model import RecordFit, RefittedModel
from robotid.diagnosis.scoring.blocked_regression import Gain
from robotid.diagnosis.scoring.catalogue_candidates import term_candidate
from robotid.diagnosis.scoring.projection import Projected
from robotid.diagnosis.scoring.ranking import CandidateScan, Round
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search import (
    agreement,
    changed_record,
    mere_changes,
    record_changes,
    refits,
    rounds,
    unexplained,
)
from robotid.diagnosis.search.acceptance import (
    Step,
    collinear,
    explains_too_little,
    has_lost_its_worth,
    stands_firm,
)
from robotid.diagnosis.search.carry_over import gain_by_blocks, proven
from robotid.diagnosis.search.changed_record import Changed, Halves
from robotid.diagnosis.search.coloured import are_too_few
from robotid.diagnosis.search.constancy import Course, course, varies
from robotid.diagnosis.search.data import _is_unchanged, settled
from robotid.diagnosis.search.physical_sense import is_not_physical, is_uncertain
from robotid.diagnosis.search.refits import (
    RefitRound,
    chosen_of,
    hopeful,
    indistinguishable_energy,
    is_complete,
    keeps_promise,
    other_points,
    refit_hopeful,
    rivals,
)
from robotid.diagnosis.search.settings import ACCEPTANCE, CHANGES, CHOICE
from robotid.diagnosis.search.state import AcceptedCause, SearchResult, SearchState
from robotid.diagnosis.search.unexplained import explains_enough, stands, with_unexplained
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.parameters import Parameters
from robotid.model.port import Port
from robotid.terms import TERMS
from support.changed_record import one_that_differs
from support.plain_models import SAMPLES, plain_blocks, plain_data, plain_model, plain_record, plain_segment
from support.sensed_step import step_to
from support.tuning import sees

ANYTHING = Criteria(significance=2.0, min_improvement_sigma=0.0, max_refits=1, skip=("record_change",))


def friction(energy: float, directions: Array | None = None) -> Score:
    """Quadratic friction as it might score."""
    candidate = term_candidate(Port.MOTOR, TERMS["quadratic_friction"], (0.0,))
    return Score(candidate, energy, (2e-3,), np.eye(3)[:, :1] if directions is None else directions, np.zeros(3))


def cogging(n: float, energy: float = 100.0) -> Score:
    """Cogging of so many periods a turn as it might score."""
    return Score(
        term_candidate(Port.MOTOR, TERMS["cogging"], (0.0, 0.0, n)), energy, (1.0, 1.0), np.eye(3), np.zeros(3)
    )


def state(energy: float, *scores: Score) -> SearchState:
    """A search whose model leaves an energy, on a thousand samples, and scored so."""
    model = plain_model(energy)
    nothing = np.zeros((1, 0))
    tried = tuple(one.candidate for one in scores)
    blocks = plain_blocks(3 + sum(len(one.scored) for one in tried))
    projected = Projected(nothing, np.array([np.sqrt(energy)]), nothing, np.eye(3), np.zeros((3, 1)), blocks)
    rounds = (Round(model, projected, scores, 1.0, tried),) if scores else ()
    return SearchState(model, model, plain_data(), CandidateScan(model, (), ()), rounds=rounds)


@sees(CHOICE, "hopeful_share")
def check_half_of_the_best_score_is_hopeful() -> None:
    assert len(hopeful([friction(100.0), friction(55.0), friction(45.0)])) == 2


@sees(CHOICE, "rival_share")
def check_nine_tenths_of_the_best_score_rival_it() -> None:
    assert rivals(friction(92.0), friction(100.0))
    assert not rivals(friction(88.0), friction(100.0))


@sees(CHOICE, "complete_share")
def check_all_but_a_few_per_cent_is_everything() -> None:
    assert is_complete(98.0, 100.0)
    assert not is_complete(96.0, 100.0)


@sees(CHOICE, "least_effects")
def check_three_effects_are_refitted_however_many_changes_of_records_score_better() -> None:
    other = replace(friction(9.0).candidate, name="record_change.a.motor.viscous.Fv")
    changes = [replace(friction(9.0, np.eye(6)[:, k : k + 1]), candidate=other) for k in range(6)]
    found = chosen_of([*changes, *[friction(5.0)] * 6], Criteria(max_refits=4))
    assert len(found) == 4 + 3


@sees(ACCEPTANCE, "telling_blocks")
def check_three_blocks_more_than_amplitudes_have_a_spread() -> None:
    assert are_too_few(3.9, 1)
    assert not are_too_few(4.1, 1)


@sees(CHOICE, "max_rounds")
def check_three_rounds_of_candidates_are_refitted() -> None:
    tried = list[str]()
    names = [n for n in TERMS if any(p.null is not None for p in TERMS[n].parameters)]
    scores = [replace(friction(90.0), candidate=replace(friction(1.0).candidate, name=name)) for name in names]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            refits, "_refits", lambda chosen, *_: tried.extend(s.candidate.name for s in chosen) or RefitRound()
        )
        refit_hopeful(state(2000.0, *scores), ANYTHING, lambda _: None)
    assert len(tried) == 3


def asked_of_refit(one: SearchState) -> tuple[list[Parameters], Any]:
    """The starts and options with which the best candidate is refitted."""
    asked = list[tuple[list[Parameters], Any]]()

    def refit(_: Any, starts: list[Parameters], data: Any, near: Any, options: Any) -> RefittedModel:
        asked.append((starts, options))
        raise NumericsError("no")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(refits, "refit", refit)
        refits._refits(one.round.scores, one, lambda _: None)
    return asked[0]


@sees(CHOICE, "start_ways")
def check_refits_start_the_whole_way_half_of_it_and_a_tenth() -> None:
    starts, _ = asked_of_refit(state(2000.0, friction(100.0)))
    assert [start["motor.quadratic_friction.Fq"] for start in starts] == pytest.approx([2e-3, 1e-3, 2e-4])


@sees(CHOICE, "good_start")
def check_a_start_that_leaves_half_is_good() -> None:
    _, options = asked_of_refit(state(2000.0, friction(100.0)))
    assert options.start_below == pytest.approx(1000.0)


@sees(CHOICE, "doubtful_share")
def check_a_periodic_effect_is_doubtful_below_half_of_the_misfit() -> None:
    def others(share: float) -> int:
        scores = [cogging(n, 1000.0 * share) for n in (3.0, 6.0)]
        return len(refits._elsewhere(scores[:1], state(2000.0, *scores)))

    assert others(0.45) == 1
    assert others(0.55) == 0


@sees(CHOICE, "kept_promise")
def check_a_refit_keeps_a_promise_by_four_fifths() -> None:
    before = state(2000.0)
    assert keeps_promise(1000.0, before, plain_model(1180.0))
    assert not keeps_promise(1000.0, before, plain_model(1220.0))


@sees(CHOICE, "other_points")
def check_two_other_points_are_tried() -> None:
    assert len(other_points(cogging(1.0), [cogging(n) for n in (1.0, 2.0, 4.0, 8.0, 16.0)])) == 2


@sees(CHOICE, "neighbour_distance")
def check_points_closer_than_a_tenth_are_neighbours() -> None:
    assert not other_points(cogging(6.0), [cogging(6.5)])
    assert other_points(cogging(6.0), [cogging(6.8)])


@sees(ACCEPTANCE, "unchanged_share")
def check_a_refit_that_changes_two_per_cent_has_changed() -> None:
    def unchanged(share: float) -> bool:
        before = plain_segment(1000.0)
        after = replace(before, residual=before.residual + np.sqrt(share))
        return _is_unchanged([before], plain_model(1000.0, fitted=(after,)))

    assert unchanged(0.018)
    assert not unchanged(0.022)


@sees(ACCEPTANCE, "same_share")
def check_of_a_large_misfit_two_per_cent_are_no_difference() -> None:
    assert indistinguishable_energy(1e5, 1.0) == pytest.approx(2000.0)


@sees(ACCEPTANCE, "same_energy")
def check_of_a_small_misfit_chance_decides() -> None:
    assert indistinguishable_energy(500.0, 1.0) == pytest.approx(12.0)


@sees(ACCEPTANCE, "max_same_share")
def check_a_tenth_is_a_difference_whatever_chance_may_do() -> None:
    assert indistinguishable_energy(50.0, 1.0) == pytest.approx(5.0)


@sees(ACCEPTANCE, "least_share")
def check_a_thousandth_of_the_misfit_is_too_little() -> None:
    def step(share: float) -> Step:
        return Step(plain_model(2000.0), plain_model(2000.0), plain_model(2000.0 - 1000.0 * share), plain_data())

    assert explains_too_little(step(1.2e-3), ANYTHING) is None
    assert explains_too_little(step(0.8e-3), ANYTHING) is not None


@sees(ACCEPTANCE, "least_motion")
def check_what_moves_a_three_hundredth_of_the_motion_is_worth_it_whatever_the_misfit() -> None:
    motion = np.full(SAMPLES, 100.0)
    motion[::2] = -100.0
    record = replace(plain_record(), dphi_m=motion)
    whole = 100.0**2 * SAMPLES

    def step(share: float) -> Step:
        before, after = (replace(plain_segment(e), record=record) for e in (whole * share + 1000.0, 1000.0))
        models = (plain_model(one.energy, fitted=(one,)) for one in (before, after))
        return Step(plain_model(whole), *models, plain_data())

    assert explains_too_little(step(1.2e-5), ANYTHING) is None
    assert explains_too_little(step(0.8e-5), ANYTHING) is not None


@sees(ACCEPTANCE, "worthless_share")
def check_a_cause_that_explains_a_tenth_of_what_it_did_has_lost_its_worth() -> None:
    assert has_lost_its_worth(0.04, 0.5)
    assert not has_lost_its_worth(0.06, 0.5)


@sees(ACCEPTANCE, "firm_factor")
def check_a_cause_is_not_tried_without_where_it_has_five_times_that_to_lose() -> None:
    model = plain_model(2000.0)
    cause = AcceptedCause("motor.cogging", 0.5, 1.0, 0.0, ("motor.cogging",), model, model)
    assert stands_firm(cause, 0.26)
    assert not stands_firm(cause, 0.24)


@sees(ACCEPTANCE, "collinear_cosine")
def check_columns_at_an_angle_of_three_degrees_are_told_apart() -> None:
    def names(degrees: float) -> list[str]:
        angle = np.radians(degrees)
        other = friction(1.0, np.array([[np.cos(angle)], [np.sin(angle)], [0.0]]))
        seen = state(2000.0, other).round
        return collinear(friction(1.0), seen)

    assert names(2.0)
    assert not names(3.0)


def left_curve(share: float) -> SearchResult:
    """A result that leaves a curve of this share of a misfit, if that is worth a word."""
    basis: Any = SimpleNamespace(forces=())
    curve = FittedCurve(basis, None, 1000.0 * share, np.zeros(1), np.zeros(3), (np.full(1, 500.0),))  # type: ignore[arg-type]
    seen = state(2000.0, friction(1.0))
    result = SearchResult(seen.data, seen.first, seen.model, (), (), seen.rounds)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(unexplained, "fit_curves", lambda *_: [curve])
        patch.setattr(unexplained, "fit_acting", lambda *_: curve)
        patch.setattr(unexplained, "curve_p_value", lambda *_: 0.0)
        return with_unexplained(result, ANYTHING)


@sees(ACCEPTANCE, "unknown_share")
def check_a_curve_of_a_tenth_of_the_misfit_is_news() -> None:
    assert left_curve(0.12).curve is not None
    assert left_curve(0.08).curve is None


@sees(ACCEPTANCE, "imitation_share")
def check_causes_that_explain_seven_tenths_of_a_curve_stand_beside_torque_errors() -> None:
    data = plain_data(noise_reached=False)
    assert stands(0.72, 1.0, data, alone=True)
    assert not stands(0.68, 1.0, data, alone=True)


@sees(ACCEPTANCE, "complete_share")
def check_causes_that_explain_nearly_all_stand_beside_any_curve() -> None:
    assert explains_enough(0.98, plain_data())
    assert not explains_enough(0.96, plain_data())


@sees(ACCEPTANCE, "clear_share")
def check_two_causes_must_be_clearly_better_than_a_curve_and_one_may_be_a_little_worse() -> None:
    assert stands(0.885, 0.9, plain_data(), alone=True)
    assert not stands(0.875, 0.9, plain_data(), alone=True)
    assert stands(0.925, 0.9, plain_data(), alone=False)
    assert not stands(0.915, 0.9, plain_data(), alone=False)


@sees(ACCEPTANCE, "trusted_causes")
def check_two_causes_are_trusted_before_they_are_compared_with_a_curve() -> None:
    asked = list[int]()
    model = plain_model(2000.0)
    cause = AcceptedCause("motor.cogging", 0.5, 1.0, 0.0, ("motor.cogging",), model, model)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(SearchState, "scored", lambda self, _: replace(self, rounds=(*self.rounds, None)))
        patch.setattr(SearchState, "with_model", lambda self, *_: self)
        patch.setattr(rounds, "add_cause", lambda one, *_: one.with_cause(cause))
        patch.setattr(rounds, "drop_worthless", lambda one, *_: one)
        patch.setattr(rounds, "renew_noise", lambda one: one)
        patch.setattr(rounds, "better_curve", lambda one, _: asked.append(len(one.causes)))
        patch.setattr(rounds, "with_unexplained", lambda result, _: result)
        rounds.find_causes(state(2000.0), ANYTHING, lambda _: None)
    assert asked == [2, 4]


@sees(CHANGES, "loud_energy")
def check_a_record_with_twice_the_usual_energy_asks_for_a_reason() -> None:
    assert agreement.is_loud([plain_segment(2 * 1100.0)], 1.0, "speed")
    assert not agreement.is_loud([plain_segment(2 * 900.0)], 1.0, "speed")


def standing_changes(*explained: list[float]) -> list[tuple[record_changes.RecordChange, ...]]:
    """The changes of a record that stand, where parameters explain these shares of its misfit: the first by themselves,
    those of every further list beside the best of those before."""
    model, one = plain_model(1000.0), plain_segment(40_000.0)
    before = RecordFit((one,), "speed")
    halves = Halves(model, (Segment(one.record, UNIT_WHITENING),), before, 1.0)

    def asked_for(_: Halves, at: Changed) -> list[Changed]:
        found = []
        for number, share in enumerate([*explained, ()][len(at.candidates)]):
            name = f"record_change.a.motor.inertia.{len(at.candidates)}{number}"
            candidate = RecordChangeCandidate(name, (0.0,), "a", number, model.joint.declared[0])
            energy = at.after.energy - share * halves.beyond(before)
            after = plain_segment(energy, fit_percent=at.after.fit_percent + 1.0)
            found.append(Changed((*at.candidates, candidate), (*at.values, 0.1), RecordFit((after,), "speed")))
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(record_changes, "_asked_for", asked_for)
        return [one.changes for one in record_changes._growing(halves, 1.1, record_changes.CHANGES.most)]


@sees(CHANGES, "confirmed_share")
def check_a_change_must_remove_a_fifth_of_the_misfit() -> None:
    assert len(standing_changes([0.22])) == 1
    assert not standing_changes([0.18])


@sees(CHANGES, "same_share")
def check_changes_two_per_cent_apart_are_told_apart() -> None:
    ((found,),) = standing_changes([0.5, 0.485, 0.475])
    assert len(found.twins) == 2


@sees(CHANGES, "most")
def check_a_payload_changes_inertia_and_both_parts_of_a_weight() -> None:
    assert [len(one) for one in standing_changes([0.5], [0.3], [0.199])] == [1, 3]
    assert [len(one) for one in standing_changes([0.5], [0.3], [0.1], [0.099])] == [1]


@sees(CHANGES, "far_off")
def check_a_record_is_far_off_at_twice_the_worst_of_drawn_noise() -> None:
    one = plain_segment(1000.0)
    for factor, far in ((1.9, False), (2.1, True)):
        drawn = [[one.residual / 3.0, one.residual / factor]]
        assert agreement._is_far_off([one], drawn) is far
    assert not agreement._is_far_off([one], [[]])


@sees(CHANGES, "apart")
def check_a_record_that_differs_thrice_as_much_as_any_other_is_another() -> None:
    found, patch = one_that_differs(), pytest.MonkeyPatch()
    size = found.last.parameters[found.causes[0].effect]
    for times, alone in ((3.1, True), (2.9, False)):
        with patch.context() as patched:
            patched.setattr(mere_changes, "_asked_for", lambda *_, times=times: size / times)
            assert (mere_changes._as_much_elsewhere(found.causes[0], found) is None) is alone


@sees(CHANGES, "shortest_part")
def check_a_part_of_a_record_is_at_least_an_eighth_of_it() -> None:
    segment = plain_segment(1.0)
    burst = np.zeros(len(segment.record))
    burst[:2] = 1.0
    (first,), (second,) = changed_record._parts([replace(segment, residual=burst)])
    assert len(first.record) / len(second.record) == pytest.approx(1 / 7, rel=0.02)


@sees(CHANGES, "max_iterations")
def check_a_change_is_fitted_in_six_iterations() -> None:
    asked = list[Any]()

    def solve(problem: Any, start: Array, options: Any, **_: Any) -> Any:
        asked.append(options)
        return SimpleNamespace(evaluation=None)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(changed_record, "solve", solve)
        changed_record.run(plain_model(1000.0), [Segment(plain_segment(1.0).record, UNIT_WHITENING)])
    assert 5 <= asked[0].max_iterations <= 8  # of one parameter, where the model is right but for it


@sees(ACCEPTANCE, "physical_sigma")
def check_what_may_be_physical_within_two_deviations_is() -> None:
    for value, sense in ((1.62, True), (1.58, False)):
        step = step_to("motor.thermal_friction", {"c": 0.5, "T": value}, {"T": 0.2})
        assert (is_not_physical(step, ANYTHING) is None) is sense


@sees(ACCEPTANCE, "amplitude_sigma")
def check_three_deviations_from_nothing_are_certain() -> None:
    for size, certain in ((3.1, True), (2.9, False)):
        step = step_to("motor.asymmetric_coulomb", {"dFc": size}, {"dFc": 1.0})
        assert (is_uncertain(step, ANYTHING) is None) is certain


@sees(ACCEPTANCE, "known_sigma")
def check_a_size_is_known_better_than_to_itself_in_whatever_shape() -> None:
    """Of the two the shape is known so badly that the size may be anything."""
    for deviation, certain in ((0.9, True), (1.1, False)):
        step = step_to("motor.thermal_friction", {"c": 1.0, "T": 20.0}, {"c": 0.01, "T": 1.0})
        factor, names = step.after.factor.copy(), step.after.parameters.names
        c, T = (names.index(f"motor.thermal_friction.{symbol}") for symbol in "cT")
        factor[c, T], factor[T, T] = 100.0 * deviation, 1.0
        assert (is_uncertain(replace(step, after=replace(step.after, factor=factor)), ANYTHING) is None) is certain


@sees(ACCEPTANCE, "gain_level")
def check_one_imitator_in_twenty_passes_for_a_gain() -> None:
    assert proven(Gain(np.ones(3), 0.04))
    assert not proven(Gain(np.ones(3), 0.06))
    assert not proven(Gain(-np.ones(3), 0.04))


@sees(ACCEPTANCE, "gain_blocks")
def check_held_out_records_are_cut_into_twenty_blocks() -> None:
    assert len(gain_by_blocks((plain_segment(2.0),), (plain_segment(1.0),)).blocks) == 20


@sees(ACCEPTANCE, "constant_parts")
def check_a_cause_is_compared_in_four_parts_of_the_records() -> None:
    assert len(course(plain_blocks(2)).parts) == 4


@sees(ACCEPTANCE, "constant_spread")
def check_a_cause_may_vary_by_half_of_its_size() -> None:
    assert varies(Course(np.ones(4), 0.55, 1e-9), 1e-3)
    assert not varies(Course(np.ones(4), 0.45, 1e-9), 1e-3)
    assert not varies(Course(np.ones(4), 0.55, 1e-2), 1e-3)


@sees(ACCEPTANCE, "noise_renewals")
def check_a_noise_that_falls_is_renewed_three_times() -> None:
    assert settled(1.0, lambda level: 0.5 * level, float) == pytest.approx(0.125)


@sees(ACCEPTANCE, "settled_noise")
def check_a_noise_that_falls_by_a_fifth_is_renewed() -> None:
    assert settled(1.0, lambda level: 0.85 * level, float) == pytest.approx(0.85)
    assert settled(1.0, lambda level: 0.75 * level, float) < 0.5
