"""The effect that the torque asks for along the measured motion, whatever a simulation has made of it.

A model that lacks most of what moves a joint is fitted to parameters of another joint, and simulates another motion.
Along that one, the effect that is lacking may score next to nothing. The measured motion is not led astray: there the
recorded torque is regressed on the rigid joint with each candidate besides. Where the motor rests, dry friction takes
what torque there is: no model explains that, and it would pass for something that no effect does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import EFFECTS, assemble
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refitted_model import RefittedModel, carried, extended
from robotid.diagnosis.scoring.candidate import Candidate
from robotid.diagnosis.scoring.periods import Wave, period_peaks
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search.refits import CandidateRefit, by_pieces, in_order, on_the_whole
from robotid.diagnosis.search.settings import ACCEPTANCE, CHOICE
from robotid.diagnosis.search.state import SearchState
from robotid.errors import NumericsError
from robotid.estimate.regressor import FilteredRecord, moving, regress_on
from robotid.estimate.rest import at_rest
from robotid.estimate.rigid import RigidResult, fit_rigid, fit_rigid_on
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure, is_change
from robotid.model.term import Role
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.record import Record


@dataclass(frozen=True, slots=True, eq=False)
class Regressed:
    """A candidate's regression. left : squared torque error, a sum over records of parts of the torque; values : of the
    parameters, by dotted name."""

    score: Score
    structure: Structure
    left: float
    values: Mapping[str, float]


def asked_for(state: SearchState, criteria: Criteria) -> list[CandidateRefit]:
    """The candidates of the last round with which the measured motion explains the torque best, as far as it tells, the
    model refitted with each from there, the best refit first; none where no candidate takes most of what the torque
    leaves without it, or no refit leads anywhere."""
    records = [replace(one, name=f"{k}") for k, one in enumerate(state.recorded)]
    structure, parameters = state.model.structure, state.model.parameters
    try:
        filtered, before = _regression(assemble(structure), parameters, records)
    except NumericsError:
        return []
    found, whole = list(_regressed(state, filtered, before)), _left(before)
    most = max((whole - one.left for one in found), default=0.0)
    if most < (1.0 - CHOICE.good_start) * whole:
        return []
    alike = [one for one in found if whole - one.left >= (1.0 - ACCEPTANCE.same_share) * most]
    start = parameters.with_values(state.start) if state.start else parameters
    refits = (
        _refitted(one, carried(start, one.structure, one.values), state)
        for one in _best_of_each(alike)[: criteria.max_refits]
    )
    return in_order([one for one in refits if one is not None], state, criteria)


def _regression(
    joint: Joint, parameters: Parameters, records: Sequence[Record]
) -> tuple[list[FilteredRecord], RigidResult]:
    """The records through the filter that passes the motion of all, and the regression of a model on them: where the
    motor moves, or on the whole of them where that is too little. Raises NumericsError where that is, too."""
    whole = fit_rigid(joint, parameters, records)
    parallel = ParallelFilter(min(whole.cutoff.values()))
    resting = [(record, at_rest(record)) for record in records]
    moving_only = [FilteredRecord(record, parallel, rest) for record, rest in resting if not rest.all()]
    with suppress(NumericsError):
        return moving_only, fit_rigid_on(moving_only, joint, parameters)
    filtered = [FilteredRecord(record, parallel) for record in records]
    return filtered, fit_rigid_on(filtered, joint, parameters)


def _refitted(one: Regressed, start: Parameters, state: SearchState) -> CandidateRefit | None:
    """The model refitted from where a regression is, by short pieces or on the whole records: whichever ends where the
    held-out records are explained better, for either may leave a valley that the measured motion has found."""
    ways = [way(one.score, one.structure, start, state) for way in (by_pieces, on_the_whole)]
    return min((way for way in ways if way is not None), key=lambda way: _unexplained(way.model), default=None)


def _unexplained(model: RefittedModel) -> float:
    return model.validation_energy if model.validation else model.energy


def _best_of_each(found: Sequence[Regressed]) -> list[Regressed]:
    """The best point of each effect's grid, the simplest law first: of laws that are one on this motion, as gravity and
    a cogging of one period a turn, that is refitted in any case."""
    best: dict[str, Regressed] = {}
    for one in sorted(found, key=lambda one: one.left):
        best.setdefault(one.score.candidate.name, one)
    return sorted(best.values(), key=lambda one: len(one.score.candidate.parameters))


def _regressed(state: SearchState, filtered: Sequence[FilteredRecord], before: RigidResult) -> Iterator[Regressed]:
    """All candidates that depend on a rigid motion alone, at every point of their grids and at the numbers of periods
    that the torque itself shows. before : the regression without them."""
    scores = [one for one in state.round.scores if _is_effect(one.candidate.name)]
    points = [(one, one.candidate) for one in scores]
    for score, candidate in (*points, *_periodic(scores, state, filtered, before)):
        effect = candidate.start(candidate.whole)
        structure, parameters = extended(state.model, candidate.name, effect)
        joint = assemble(structure)
        try:
            rigid = fit_rigid_on(filtered, joint, parameters)
        except NumericsError:
            continue
        yield Regressed(score, structure, _left(rigid), dict(effect) | _values(rigid, parameters, joint))


def _is_effect(name: str) -> bool:
    return not is_change(name) and name.partition(".")[2] in EFFECTS


def _periodic(
    scores: Sequence[Score], state: SearchState, filtered: Sequence[FilteredRecord], before: RigidResult
) -> Iterator[tuple[Score, Candidate]]:
    """Effects that go round with an angle at the peaks of the spectrum of what the torque lacks, over the measured
    angle, each with the best score of its effect: the scores are read off a simulation that may have lost its phase."""
    best: dict[Candidate, tuple[int, Score]] = {}
    for one in scores:
        if (k := one.candidate.counting) is not None:
            best.setdefault(one.candidate.at(k, 0.0), (k, one))
    linear = state.model.structure.linear
    for flat, (k, score) in best.items():
        waves = list(_waves(flat, state, filtered, before))
        if waves:
            yield from ((score, flat.at(k, n)) for n in period_peaks(waves, flat.parameters[k].grid, linear=linear))


def _waves(
    flat: Candidate, state: SearchState, filtered: Sequence[FilteredRecord], before: RigidResult
) -> Iterator[Wave]:
    """What the torque of each record lacks, over the angle that an effect goes round with. flat : it, of no periods."""
    own = dict(zip((f"{flat.name}.{p.symbol}" for p in flat.parameters), flat.values, strict=True))
    structure, parameters = extended(state.model, flat.name, {})
    joint, known = assemble(structure), parameters.all_fixed.with_values(before.guesses | own)
    scored = {f"{flat.name}.{flat.parameters[k].symbol}" for k in flat.scored}
    known = replace(known, free=np.array([name in scored for name in known.names]))
    turn = next((factor for place, factor in moving(joint) if place.effect == flat.name), None)
    if turn is None:
        return
    for one in filtered:
        lacking, kept = regress_on(one, joint, known), one.telling(one.apply(one.motion.speed))
        yield Wave(one.apply(turn * one.record.phi_m)[kept], lacking.tau * lacking.columns.sum(axis=0))


def _left(rigid: RigidResult) -> float:
    return float(np.sum(np.square(list(rigid.torque_error_percent.values()))))


def _values(rigid: RigidResult, parameters: Parameters, joint: Joint) -> dict[str, float]:
    """What a regression tells of free parameters, but for masses where there are several: it knows their sum alone."""
    masses = joint.playing(Role.MASS)
    shared = masses if len(masses) > 1 else {}
    free = dict(zip(parameters.names, parameters.free.tolist(), strict=True))
    return {name: value for name, value in rigid.guesses.items() if name not in shared and free.get(name, False)}
