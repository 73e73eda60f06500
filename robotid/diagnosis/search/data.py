"""Setting up a bench: the records of a model, and the noise that shows behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import Whitening, whitened_energy, whitening
from robotid.diagnosis.nonparametric.curve_fit import free_forces
from robotid.diagnosis.refit.refitted_model import EvaluationData, Motions, RefittedModel, refit
from robotid.diagnosis.scoring.candidates import candidates
from robotid.diagnosis.scoring.noise_estimate import estimate_noise
from robotid.diagnosis.scoring.ranking import CandidateScan, look, update_residuals
from robotid.diagnosis.scoring.score_test import Scan, scans, unexplained
from robotid.estimate.fitted_model import FittedModel, Simulated
from robotid.estimate.residual import OutputError
from robotid.model.array import Array
from robotid.signals.record import Record

ALIKE = 0.02  # of the residual's energy: a refit that changes less of it leaves the model as it was looked at


def set_up(
    model: FittedModel,
    fitted: Sequence[Simulated],
    held: Sequence[Record],
    horizon: float | None,
    criteria: Criteria,
    *,
    errors: bool = False,
) -> tuple[EvaluationData, CandidateScan]:
    """The bench for a fitted model, its noise found in the residuals, and a look at the model refitted on it."""
    segments = [segment for run in fitted for segment in run.segments(model.output)]
    pieces = tuple(segment.record for segment in segments)
    trajectories = tuple(segment.trajectory for segment in segments)
    bare = OutputError(model.joint, model.parameters, pieces, model.output, np.ones(len(pieces)), model.estimate_states)
    missing = candidates(model.joint.structure, model.output, criteria.skip)
    seen = scans(segments, model.output, bare.columns, bare.free_states, missing)
    whiten, reached = estimate_noise(seen, model.output, bare.row, lambda: _freed(seen, bare), errors=errors)
    held_pieces = tuple(piece for record in held for piece in record.pieces(horizon or record.duration))
    whiten_held = _held_whitening(bare, model.theta, whiten, held_pieces)
    bench = EvaluationData(
        pieces, held_pieces, whiten, whiten_held, model.output, model.estimate_states, reached, errors
    )
    first = refit(model.joint.structure, [model.parameters], bench, Motions(trajectories), careful=True)
    moved = [after - before.residual for after, before in zip(first.residuals, segments, strict=True)]
    alike = whitened_energy(moved, whiten) < ALIKE * first.energy
    return bench, update_residuals(first, missing, seen) if alike else look(first, criteria.skip)


def renew(looked: CandidateScan, bench: EvaluationData) -> tuple[EvaluationData, RefittedModel]:
    """The bench with the noise as it shows behind a better model, never larger, and that model refitted on it."""
    trial, seen = looked.trial, looked.scans
    problem, theta = trial.problem, trial.parameters.values
    whiten, _ = estimate_noise(seen, bench.output, problem.row, lambda: _freed(seen, problem), errors=bench.errors)
    if max(w.torque for w in whiten) <= max(w.torque for w in bench.whiten):
        bench = replace(bench, whiten=whiten, whiten_held=_held_whitening(problem, theta, whiten, bench.held))
    return bench, refit(trial.structure, [trial.parameters], bench, trial.motions, careful=True)


def _freed(seen: Sequence[Scan], problem: OutputError) -> list[Array]:
    """What of each residual neither candidates nor free curves explain, (n,) each."""
    segments = [one.segment for one in seen]
    more = [free_forces(segment.trajectory, segment.record) for segment in segments]
    curves = scans(segments, problem.output, problem.columns, problem.free_states, (), more)
    both = (np.concatenate([one.signals[:-1], other.signals]) for one, other in zip(seen, curves, strict=True))
    return [unexplained(replace(one, signals=signals)) for one, signals in zip(curves, both, strict=True)]


def _held_whitening(
    problem: OutputError, theta: Array, whiten: Sequence[Whitening], held: Sequence[Record]
) -> tuple[Whitening, ...]:
    """Records that were held out have the typical noise of the others."""
    typical = (float(np.median([w.output for w in whiten])), float(np.median([w.torque for w in whiten])))
    return tuple(whitening(problem.joint, theta, problem.row, record.sampling_time, typical) for record in held)
