"""Refitting: the candidates that score best, fitted with the whole model, and the best of them first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.multiple_shooting import try_from_pieces
from robotid.diagnosis.refit.refitted_model import EvaluationData, RefittedModel, extended, refit
from robotid.diagnosis.scoring.candidates import Candidate, Difference
from robotid.diagnosis.scoring.ranking import Round, best_of_each, p_value
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search.state import Log
from robotid.errors import NumericsError
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure

RIVAL = 0.9  # of the best score: candidates below it are not tried against one that explains nearly all
HOPEFUL = 0.5  # of the best score: candidates below it are not refitted
GOES = 3  # at candidates, where none of the best can be refitted
WAYS = (1.0, 0.5, 0.1)  # of the way to what a score promises, where refits start
ENOUGH = 0.5  # of a model's energy: a start that leaves less is good
DOUBTFUL = 0.5  # of the misfit: an effect that goes round and promises less is tried from other points, too
KEPT = 0.8  # of what a score promises: a refit that removes less has lost its way
POINTS, NEIGHBOURS = 2, 0.1  # how many, and how close (relative) they would be the same
REACHED = 0.97  # of the misfit: a cause that explains so much explains it

Tried = list[tuple[Score, RefittedModel]]
"""Candidates refitted, the best first."""


def refit_hopeful(now: RefittedModel, seen: Round, bench: EvaluationData, criteria: Criteria, log: Log) -> Tried:
    """The candidates of a round that score best, refitted; where none of them can be, other points of their grids and
    the candidates that follow."""
    points = [s for s in seen.scores if s.energy > criteria.min_improvement_sigma**2 * bench.samples]
    failed = set[str]()
    for _ in range(GOES):
        each = [s for s in best_of_each(points) if p_value(s, seen, bench) < criteria.significance]
        new = [s for s in each if s.candidate.name not in failed]
        hopeful = [s for s in new if s.energy > HOPEFUL * new[0].energy][: criteria.max_refits]
        again = [s for s in each if s.candidate.name in failed]
        chosen = [*again, *hopeful, *_elsewhere(now, hopeful, seen, bench)]
        tried = list(_refit(now, chosen, seen, bench, log))
        if tried:
            return _in_order(tried, bench, criteria)
        done = {s.candidate for s in chosen}
        failed |= {candidate.name for candidate in done}
        points = [s for s in points if s.candidate not in done]
    return []


def _elsewhere(now: RefittedModel, hopeful: Sequence[Score], seen: Round, bench: EvaluationData) -> list[Score]:
    """The best effect from other numbers of periods a turn, where its columns explain so little that the best of them
    may well be the wrong one; a refit does not get from one to another."""
    if not hopeful or hopeful[0].energy > DOUBTFUL * (now.energy - bench.samples):
        return []
    if not any(p.turns for p in hopeful[0].candidate.effect.parameters):
        return []
    chosen = [hopeful[0]]
    for one in seen.scores:
        if one.candidate.name == chosen[0].candidate.name and all(_apart(one.candidate, c.candidate) for c in chosen):
            chosen.append(one)
    return chosen[1 : 1 + POINTS]


def _apart(one: Candidate, other: Candidate) -> bool:
    """Whether two points of a grid are no neighbours."""
    return not np.allclose(one.values, other.values, rtol=NEIGHBOURS, atol=0.0)


def _refit(
    now: RefittedModel, hopeful: Sequence[Score], seen: Round, bench: EvaluationData, log: Log
) -> Iterator[tuple[Score, RefittedModel]]:
    """Refits in the order of the scores; once one explains nearly all, only what scores nearly as well is tried."""
    reached, explained = False, 0.0
    for one in hopeful:
        if reached and one.energy < RIVAL * hopeful[0].energy:
            continue
        log(f"refitting with {one.candidate.name}")
        try:
            after = _refitted(now, one, seen.trial, bench, explained)
        except NumericsError:
            continue
        explained = max(explained, now.energy - after.energy)
        reached = explained > REACHED * (now.energy - bench.samples)
        yield one, after


def _in_order(tried: Tried, bench: EvaluationData, criteria: Criteria) -> Tried:
    """By the criterion, each effect once; but what has fewer parameters goes before the best where the difference is
    not worth a word."""
    each: dict[str, tuple[Score, RefittedModel]] = {}
    for one, after in sorted(tried, key=lambda pair: _criterion(pair[1], bench)):
        each.setdefault(one.candidate.name, (one, after))
    ordered = list(each.values())
    least = ordered[0][1].energy + criteria.min_improvement_sigma**2 * bench.samples if ordered else 0.0
    return sorted(ordered, key=lambda pair: len(pair[1].problem.columns) if pair[1].energy <= least else np.inf)


def _criterion(trial: RefittedModel, bench: EvaluationData) -> float:
    """Bayesian information criterion, up to a constant, of a residual whose variance is unknown."""
    return bench.samples * float(np.log(trial.energy)) + len(trial.problem.columns) * float(np.log(bench.samples))


def _refitted(
    now: RefittedModel, one: Score, seen: RefittedModel, bench: EvaluationData, explained: float
) -> RefittedModel:
    """The model with a candidate, from where its score promises the end; from part of the way where that is too far,
    and from short pieces where it breaks a large promise. seen : the model in which the candidate was seen; explained :
    energy that others explain. Raises NumericsError where it explains nothing."""
    starts = [_start(seen, one, way) for way in WAYS]
    structure, parameters, enough = starts[0][0], [p for _, p in starts], ENOUGH * now.energy
    large = one.energy > max(explained, DOUBTFUL * (now.energy - bench.samples))
    after: RefittedModel | None = None
    try:
        after = refit(structure, parameters, bench, now.motions, enough=enough, below=now.energy)
        kept = now.energy - after.energy > KEPT * one.energy and after.held_energy <= now.held_energy
        if kept or not large:
            return after
    except NumericsError:
        if not large:
            raise
    try:
        again = try_from_pieces(structure, parameters, bench, enough=enough, below=now.energy)
    except NumericsError:
        if after is None:
            raise
        return after
    return again if after is None or again.energy < after.energy else after


def _start(seen: RefittedModel, one: Score, way: float) -> tuple[Structure, Parameters]:
    """The extended structure, and its parameters a part of the way from the null to what the score promises."""
    c, columns = one.candidate, seen.problem.columns
    amplitude = [way * a for a in one.amplitude]
    values = dict(zip((p.symbol for p in c.effect.parameters), c.values, strict=True))
    values |= dict(zip((c.effect.parameters[k].symbol for k in c.scored), amplitude, strict=True))
    whole = isinstance(c.effect, Difference)  # its name is that of its only parameter
    named = {c.name if whole else f"{c.name}.{symbol}": value for symbol, value in values.items()}
    old = seen.parameters
    moved = {old.names[k]: old.values[k] + way * d for k, d in zip(columns, one.moved, strict=True)}
    return extended(seen, c.name, moved | named)
