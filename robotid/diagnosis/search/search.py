"""The search for what a model lacks: score, refit the best few, keep what pays on records held out, and repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.nonparametric.curve_fit import Shape, acting_along, in_motion, shapes
from robotid.diagnosis.refit.refitted_model import EvaluationData, RefittedModel, refit
from robotid.diagnosis.scoring.ranking import CandidateScan, Round, look, rank
from robotid.diagnosis.scoring.score_test import significance
from robotid.diagnosis.search.acceptance import accept, drop, found, objection
from robotid.diagnosis.search.data import renew, set_up
from robotid.diagnosis.search.record_changes import changes
from robotid.diagnosis.search.refits import Tried, refit_hopeful
from robotid.diagnosis.search.state import Found, Log, RejectedCause, SearchResult, misfit_energy, share_removed
from robotid.estimate.fitted_model import FittedModel, Simulated
from robotid.model.structure import RECORD_CHANGE
from robotid.signals.record import Record

NOTHING = 0.1  # of the misfit: a curve that explains less of it is no news
IMITATES = 0.7  # of what a free curve explains: causes that do not reach it only imitate something else
COMPLETE = 0.97  # of the misfit: causes that explain so much are the causes, where a model could reach the noise
CLEARLY = 0.02  # of the misfit: by how much other causes must be better there than a free curve; one may be worse by it
TRUSTED = 2  # causes that are added before the question is asked whether they only imitate


def search(
    model: FittedModel,
    fitted: Sequence[Simulated],
    held: Sequence[Record],
    horizon: float | None,
    criteria: Criteria,
    log: Log,
) -> SearchResult:
    """What a model lacks that was simulated so, by the noise of the sensors; and where that is out of reach and names
    nothing, as it is on most machines, by that of torque errors besides. held : records held out; horizon [s] : of
    the pieces that start afresh."""
    log("measuring the noise")
    bench, looked = set_up(model, fitted, held, horizon, criteria)
    growth = grow(looked, bench, criteria, log)
    if growth.causes or bench.reached:
        return growth
    log("allowing for errors of the torque")
    bench, looked = set_up(model, fitted, held, horizon, criteria, errors=True)
    blunt = grow(looked, bench, criteria, log)
    return blunt if blunt.causes or growth.shape is None else growth


def grow(looked: CandidateScan, bench: EvaluationData, criteria: Criteria, log: Log) -> SearchResult:
    """Extend a model cause by cause."""
    first, now, before = looked.trial, looked.trial, bench
    causes, turned, rounds, imitated = list[Found](), list[RejectedCause](), list[Round](), None
    while len(causes) < criteria.max_causes and len(rounds) < 2 * criteria.max_causes:
        log(f"scoring the catalogue for cause {len(causes) + 1}")
        seen = rank(looked, bench, criteria)
        rounds.append(seen)
        tried = refit_hopeful(now, seen, bench, criteria, log)
        one = accept(first, now, tried, seen, bench, criteria, turned)
        new = [one] if one is not None else _together(first, now, tried, seen, bench, criteria, log)
        if not new:
            break
        causes, now = _without_worthless(first, [*causes, *new], bench, criteria, turned, log)
        looked = look(now, criteria.skip)
        bench, now = renew(looked, bench)
        imitated = _imitated(first, now, bench) if len(causes) == TRUSTED else None
        if imitated is not None:
            break
    log("looking for what no effect explains")
    growth = SearchResult(bench, first, now, _by_one_noise(causes, first, bench), tuple(turned), tuple(rounds))
    if causes and len(causes) != TRUSTED:
        imitated = _imitated(first, now, bench)
    growth = _with_unknown(growth, criteria) if imitated is None else _as_unknown(growth, imitated, before)
    if RECORD_CHANGE in criteria.skip:
        return growth
    log("comparing the records held out")
    return replace(growth, changes=changes(growth.last, growth.bench))


def _together(
    first: RefittedModel,
    now: RefittedModel,
    tried: Tried,
    seen: Round,
    bench: EvaluationData,
    criteria: Criteria,
    log: Log,
) -> list[Found]:
    """Two causes that carry over only beside each other: without the second, the fit bends the first to imitate it."""
    if not tried or share_removed(first, now, tried[0][1], bench) < NOTHING:
        return []
    alone = found(first, now, tried, seen, bench)
    log(f"looking for a second cause beside {alone.effect}")
    more = rank(look(alone.after, criteria.skip), bench, criteria)
    pairs = refit_hopeful(alone.after, more, bench, criteria, log)
    for k, (_, after) in enumerate(pairs):
        if objection(first, now, after, bench, criteria) is None:
            return [alone, found(first, alone.after, pairs[k:], more, bench)]
    return []


def _without_worthless(
    first: RefittedModel,
    causes: list[Found],
    bench: EvaluationData,
    criteria: Criteria,
    turned: list[RejectedCause],
    log: Log,
) -> tuple[list[Found], RefittedModel]:
    """The causes that keep their worth once the last is there, and the model with them."""
    last = causes[-1]
    if len(causes) > 1:
        log("trying without the earlier causes")
    kept, now = drop(first, causes, last.after, bench, criteria)
    for one in causes:
        if one.effect not in {k.effect for k in kept}:
            turned.append(
                RejectedCause(one.effect, one.explained, one.gain, f"lost its worth once {last.effect} was there")
            )
    return kept, now


def _by_one_noise(causes: Sequence[Found], first: RefittedModel, bench: EvaluationData) -> tuple[Found, ...]:
    """The causes with what each explains beside those before it by the noise as it shows at last; when they were found
    it was taken for larger, and shares by different noises do not add up."""
    models = pairwise([first, *(one.after for one in causes)])
    shares = [share_removed(first, before, after, bench) for before, after in models]
    return tuple(replace(one, explained=share) for one, share in zip(causes, shares, strict=True))


def _with_unknown(growth: SearchResult, criteria: Criteria) -> SearchResult:
    """The search with the curve that explains most of what it leaves, where that is worth a word."""
    bench, whole = growth.bench, misfit_energy(growth.first, growth.bench)
    remaining = growth.last.energy - bench.samples
    if whole <= 0.0 or remaining < max(criteria.min_improvement_sigma**2 * bench.samples, NOTHING * whole):
        return growth
    left = next(iter(shapes(growth.last, bench)), None)
    if left is None or left.energy < NOTHING * whole or not _curve_stands(left, growth, criteria):
        return growth
    left = in_motion(left, growth.last, bench)
    share = _share(left, growth.first, bench)
    if share < NOTHING or (
        bench.held and left.held_energy < criteria.min_improvement_sigma**2 * sum(map(len, bench.held))
    ):
        return growth
    return replace(growth, shape=left, share=share)


def _imitated(first: RefittedModel, last: RefittedModel, bench: EvaluationData) -> Shape | None:
    """The free curve that explains clearly more of the first model's misfit than all causes do, or None."""
    samples, held_samples = bench.samples, sum(map(len, bench.held))
    enough = COMPLETE if bench.reached else IMITATES

    def share(model: RefittedModel, energy: float, held_energy: float) -> float:
        """Of a model's misfit, on the fitted records or on those held out, whichever is less."""
        whole, held = max(model.energy - samples, 1e-9), model.held_energy - held_samples
        return min(energy / whole, held_energy / held) if held > 0.0 else energy / whole

    if misfit_energy(first, bench) <= 0.0 or last.energy - samples <= 0.0:
        return None
    # By the noise as it shows now.
    again = refit(first.structure, [first.parameters], bench, first.motions, careful=True)
    explained = share(again, again.energy - last.energy, again.held_energy - last.held_energy)
    free = next(iter(shapes(again, bench)), None) if explained <= enough else None
    alone = len(last.structure.effects) == len(first.structure.effects) + 1
    clearly = -CLEARLY if alone else CLEARLY
    if free is None or _stands(explained, free.energy / max(again.energy - samples, 1e-9), clearly, bench):
        return None
    free = in_motion(free, again, bench)
    told = share(again, free.energy, free.held_energy)
    return None if _stands(explained, told, clearly, bench) else free


def _stands(explained: float, free: float, clearly: float, bench: EvaluationData) -> bool:
    """Whether causes stand that explain less than everything, beside a free curve."""
    return explained > free + clearly if bench.reached else explained > IMITATES * free


def _as_unknown(growth: SearchResult, better: Shape, before: EvaluationData) -> SearchResult:
    """The search with its causes turned down for a curve that explains the misfit better, as the noise behind the first
    model tells it: behind models that only imitate the noise is uncertain. before : the bench with that noise."""
    shape, bench = acting_along(better.variable, growth.first, before), before
    if _share(shape, growth.first, before) < NOTHING:
        shape, bench = better, growth.bench
    share = _share(shape, growth.first, bench)
    why = f"only imitates: a free curve along {shape.curve.along} explains {100 * share:.0f} % of the misfit"
    imitations = [RejectedCause(c.effect, c.explained, c.gain, why) for c in growth.causes]
    turned = (*imitations, *growth.turned)
    return replace(growth, bench=bench, last=growth.first, causes=(), turned=turned, shape=shape, share=share)


def _share(shape: Shape, first: RefittedModel, bench: EvaluationData) -> float:
    """Of the first model's misfit."""
    return float(np.clip(shape.energy / max(misfit_energy(first, bench), 1e-9), 0.0, 1.0))


def _curve_stands(shape: Shape, growth: SearchResult, criteria: Criteria) -> bool:
    bench = growth.bench
    tries = len(growth.rounds[-1].scores)
    p = significance(shape.energy, len(shape.values), growth.last.energy, bench.samples, tries)
    return p < criteria.significance and shape.energy > criteria.min_improvement_sigma**2 * bench.samples
