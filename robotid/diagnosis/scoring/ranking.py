"""Ranking what a model could lack: every candidate's columns, and the misfit that each would explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refitted_model import EvaluationData, RefittedModel
from robotid.diagnosis.scoring.candidates import Candidate, Difference, candidates, differences
from robotid.diagnosis.scoring.periods import periods
from robotid.diagnosis.scoring.resonances import resonances
from robotid.diagnosis.scoring.score_test import (
    DEPENDENT,
    Projected,
    Scan,
    Score,
    left_over,
    project,
    scans,
    score,
    significance,
)
from robotid.model.array import Array
from robotid.model.structure import RECORD_CHANGE
from robotid.simulation.sensitivities import force_gradient


@dataclass(frozen=True, slots=True, eq=False)
class CandidateScan:
    """A model with the columns of all candidates, `missing`, on every record of its fit."""

    trial: RefittedModel
    missing: tuple[Candidate, ...]
    scans: tuple[Scan, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """What one look at a model tells. trial : the model as it was looked at; inflation : energy of the residual per
    direction that no single candidate explains."""

    trial: RefittedModel
    projected: Projected
    scores: tuple[Score, ...]
    inflation: float


def look(trial: RefittedModel, skip: tuple[str, ...]) -> CandidateScan:
    """All candidates' columns through a model. skip : effects that are out of the question."""
    p = trial.problem
    missing = candidates(trial.structure, p.output, skip)
    return CandidateScan(trial, missing, scans(trial.segments, p.output, p.columns, p.free_states, missing))


def update_residuals(trial: RefittedModel, missing: tuple[Candidate, ...], before: Sequence[Scan]) -> CandidateScan:
    """A model that differs little from the one that these columns are of: its residuals beside the same columns."""
    renewed = tuple(
        replace(one, trajectory=segment.trajectory, signals=np.concatenate([one.signals[:-1], segment.residual[None]]))
        for one, segment in zip(before, trial.segments, strict=True)
    )
    return CandidateScan(trial, missing, renewed)


def rank(looked: CandidateScan, bench: EvaluationData, criteria: Criteria) -> Round:
    """All candidates by what they would explain, and every parameter as different in each record."""
    trial, known, seen = looked.trial, looked.missing, looked.scans
    names = list(dict.fromkeys(record.name for record in bench.fitted))
    wanted = len(names) > 1 and RECORD_CHANGE not in criteria.skip
    other = differences(trial.problem.joint, trial.problem.columns, names) if wanted else ()
    gradients = residual_gradients(looked, bench)
    more = (*periods(known, trial, bench.fitted, gradients), *resonances(known, trial, gradients))
    if more:
        new = scans(trial.segments, bench.output, (), (), more)
        seen = tuple(_with_more(*both) for both in zip(seen, new, strict=True))
    missing = (*known, *more, *other)
    repeated = [
        (d.record, trial.problem.columns.index(d.column)) for c in other if isinstance(d := c.effect, Difference)
    ]
    projected = project(seen, bench.whiten, repeated)
    scores = score(projected, missing)
    best = best_of_each(scores)
    return Round(trial, projected, tuple(scores), _inflation(projected, best))


def residual_gradients(looked: CandidateScan, bench: EvaluationData) -> list[Array]:
    """What the whitened residual of each record, less what the fit could still take, gains from a generalised force at
    each sample, (nv, n) each."""
    trial, residuals = looked.trial, left_over(looked.scans, bench.whiten)
    parts = zip(trial.motions.fitted, bench.whiten, residuals, strict=True)
    return [force_gradient(t, trial.problem.row, w.transposed(residual)) for t, w, residual in parts]


def _with_more(one: Scan, new: Scan) -> Scan:
    """A record with the columns of further candidates."""
    return replace(one, signals=np.concatenate([one.signals[:-1], new.signals]))


def _inflation(projected: Projected, best: Sequence[Score]) -> float:
    """Mean energy of the residual along the directions that candidates reach and the best of them does not."""
    u, values, _ = np.linalg.svd(projected.missing / np.where(projected.length > 0, projected.length, 1.0))
    reached = u[:, : int(np.sum(values > DEPENDENT * values[0]))].T @ projected.residual
    taken, k = (best[0].energy, len(best[0].amplitude)) if best else (0.0, 0)
    return max(1.0, (float(reached @ reached) - taken) / max(1, len(reached) - k))


def best_of_each(scores: Sequence[Score]) -> list[Score]:
    """The best point of each effect's grid, best first."""
    found: dict[str, Score] = {}
    for one in scores:
        if one.energy > 0:
            found.setdefault(one.candidate.name, one)
    return list(found.values())


def p_value(one: Score, seen: Round, bench: EvaluationData) -> float:
    """Of the best of all candidates; the residual that other candidates could explain counts as its noise."""
    tries, k = len(seen.scores), len(one.amplitude)
    white = significance(one.energy, k, seen.projected.energy, bench.samples, tries)
    coloured = significance(one.energy, k, one.energy + seen.inflation * len(seen.scores), len(seen.scores), tries)
    return max(white, coloured)
