"""Accepting a cause: the most promising candidates refitted, and the best that carries over to records held out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refitted_model import EvaluationData, RefittedModel, reduced, refit
from robotid.diagnosis.scoring.ranking import Round, best_of_each, p_value
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search.refits import Tried
from robotid.diagnosis.search.state import Found, RejectedCause, share_removed
from robotid.errors import NumericsError
from robotid.model.structure import rests_on

SAME = 0.02  # of the energy explained: causes closer than that are not told apart
SAME_FLOOR = 12.0  # of noise variances, inflated: as far apart as chance sets two equal models
MOST_ALIKE = 0.1  # of the energy explained, however much chance there is
LEAST = 1e-3  # of the first model's misfit energy: a cause that removes less is one of the simulation's own errors
STILL = 0.1  # of what a cause explained when it was named: one without which more is lost has not lost its worth
COLLINEAR = 0.999  # cosine at which columns are the same


def accept(
    first: RefittedModel,
    now: RefittedModel,
    tried: Tried,
    seen: Round,
    bench: EvaluationData,
    criteria: Criteria,
    turned: list[RejectedCause],
) -> Found | None:
    """The best cause of a round that stands all tests, or None."""
    for k, (best, after) in enumerate(tried):
        why = objection(first, now, after, bench, criteria)
        if why is None:
            return found(first, now, tried[k:], seen, bench)
        gain = after.held_fit_percent - now.held_fit_percent
        turned.append(RejectedCause(best.candidate.name, share_removed(first, now, after, bench), gain, why))
    return None


def objection(
    first: RefittedModel, now: RefittedModel, after: RefittedModel, bench: EvaluationData, criteria: Criteria
) -> str | None:
    """Why a refitted cause is none, in words; None where it stands."""
    if bench.held:
        gained = now.held_energy - after.held_energy
        samples = sum(map(len, bench.held))
        if gained <= 0:
            return "does not carry over: the held-out records are simulated worse with it"
        if after.held_fit_percent <= now.held_fit_percent:
            return "does not carry over: the fit of the held-out records falls with it"
    else:
        gained, samples = now.energy - after.energy, bench.samples
    share = share_removed(first, now, after, bench)
    if share < LEAST:
        return f"is not worth it: explains {100 * share:.2g} % of the misfit"
    if gained < criteria.min_improvement_sigma**2 * samples:
        return f"is not worth it: removes {np.sqrt(max(0.0, gained) / samples):.2g} noise standard deviations"
    return None


def _without(now: RefittedModel, effect: str, bench: EvaluationData) -> RefittedModel | None:
    structure, parameters = reduced(now, effect)
    try:
        return refit(structure, [parameters], bench, now.motions)
    except NumericsError:
        return None


def drop(
    first: RefittedModel, causes: Sequence[Found], now: RefittedModel, bench: EvaluationData, criteria: Criteria
) -> tuple[list[Found], RefittedModel]:
    """The causes but for the earlier ones that the last has made worthless, and the model without them. One that gains
    only beside others has the gain that it has there."""
    kept = list(causes)
    for one in causes[:-1]:
        if any(rests_on(other.effect, one.effect) for other in kept):
            continue
        lean = _without(now, one.effect, bench)
        if lean is None:
            continue
        lost = share_removed(first, lean, now, bench)
        if lost < STILL * one.explained and objection(first, lean, now, bench, criteria) is not None:
            kept.remove(one)
            last = kept[-1]
            both = share_removed(first, last.before, lean, bench) + one.explained
            rival = None if last.rival is None else _without(last.rival, one.effect, bench)
            kept[-1] = replace(last, explained=min(1.0, both), after=lean, rival=rival)
            now = lean
        elif one.gain <= 0.0:
            kept[kept.index(one)] = replace(one, gain=now.held_fit_percent - lean.held_fit_percent)
    return kept, now


def found(first: RefittedModel, now: RefittedModel, tried: Tried, seen: Round, bench: EvaluationData) -> Found:
    """The first of the refitted candidates as a cause, and the others as far as they are not told apart from it."""
    best, after = tried[0]
    explained = now.energy - after.energy
    slack = max(SAME * explained, min(SAME_FLOOR * seen.inflation, MOST_ALIKE * explained))
    alike = [(one.candidate.name, other) for one, other in tried if other.energy - after.energy <= slack]
    rivals = [other for name, other in alike if name != best.candidate.name]
    twins = [name for name, _ in alike]
    twins += [name for name in _collinear(best, seen) if name not in {one.candidate.name for one, _ in tried}]
    return Found(
        best.candidate.name,
        share_removed(first, now, after, bench),
        after.held_fit_percent - now.held_fit_percent,
        p_value(best, seen, bench),
        tuple(dict.fromkeys([best.candidate.name, *twins])),
        now,
        after,
        rivals[0] if rivals else None,
    )


def _collinear(best: Score, seen: Round) -> list[str]:
    """Effects whose columns span what those of the best do."""
    names = []
    for one in best_of_each(seen.scores):
        if one.directions.size and best.directions.size:
            cosines = np.linalg.svd(one.directions.T @ best.directions, compute_uv=False)
            if cosines.min() > COLLINEAR and one.directions.shape[1] == best.directions.shape[1]:
                names.append(one.candidate.name)
    return names
