"""Setting up a bench: the records of a model, and the noise that shows behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.estimate.residual import OutputError, observed
from robotid.judge.candidates import candidates
from robotid.judge.noise import estimate_noise
from robotid.judge.ranking import look
from robotid.judge.score import Scan, scan, unexplained
from robotid.judge.simulated import Model, measured, simulate_record
from robotid.judge.terms import Terms
from robotid.judge.trial import Bench, Motions, Trial, try_model
from robotid.judge.unknown import free_forces
from robotid.judge.whitening import Whitening, whitening
from robotid.model.array import Array
from robotid.signals.record import Record


def set_up(
    model: Model,
    fitted: Sequence[Record],
    held: Sequence[Record],
    horizon: float | None,
    terms: Terms,
    *,
    errors: bool = False,
) -> tuple[Bench, Trial]:
    """The bench for a fitted model, its noise found in the residuals, and the model refitted on it."""
    runs = [simulate_record(model, record, horizon) for record in fitted]
    pieces = [piece for run in runs for piece in run.pieces]
    trajectories = [t for run in runs for t in run.trajectories]
    bare = OutputError(
        model.joint, model.parameters, tuple(pieces), model.output, np.ones(len(pieces)), model.estimate_states
    )
    missing = candidates(model.joint.structure, model.output, terms.skip)
    scans = []
    for piece, t in zip(pieces, trajectories, strict=True):
        residual = measured(piece, model.output) - observed(t, model.output)
        scans.append(scan(t, piece, residual, model.output, bare.columns, bare.free_states, missing))
    whiten, reached = estimate_noise(scans, model.output, bare.row, lambda: _freed(scans, bare), errors=errors)
    held_pieces = tuple(piece for record in held for piece in record.pieces(horizon or record.duration))
    whiten_held = _held_whitening(bare, model.theta, whiten, held_pieces)
    bench = Bench(tuple(pieces), held_pieces, whiten, whiten_held, model.output, model.estimate_states, reached, errors)
    near = Motions(tuple(trajectories))
    return bench, try_model(model.joint.structure, [model.parameters], bench, near, careful=True)


def renew(trial: Trial, bench: Bench, terms: Terms) -> tuple[Bench, Trial]:
    """The bench with the noise as it shows behind a better model, never larger, and that model refitted on it."""
    problem, theta = trial.problem, trial.parameters.values
    scans = look(trial, terms.skip)
    whiten, _ = estimate_noise(scans, bench.output, problem.row, lambda: _freed(scans, problem), errors=bench.errors)
    if max(w.torque for w in whiten) <= max(w.torque for w in bench.whiten):
        bench = replace(bench, whiten=whiten, whiten_held=_held_whitening(problem, theta, whiten, bench.held))
    return bench, try_model(trial.structure, [trial.parameters], bench, trial.motions, careful=True)


def _freed(scans: Sequence[Scan], problem: OutputError) -> list[Array]:
    """What of each residual neither candidates nor free curves explain, (n,) each."""
    found = []
    for one in scans:
        t, more = one.trajectory, free_forces(one.trajectory, one.record)
        curves = scan(t, one.record, one.residual, problem.output, problem.columns, problem.free_states, (), more)
        found.append(unexplained(replace(curves, signals=np.concatenate([one.signals[:-1], curves.signals]))))
    return found


def _held_whitening(
    problem: OutputError, theta: Array, whiten: Sequence[Whitening], held: Sequence[Record]
) -> tuple[Whitening, ...]:
    """Records that were held out have the typical noise of the others."""
    typical = (float(np.median([w.output for w in whiten])), float(np.median([w.torque for w in whiten])))
    return tuple(whitening(problem.joint, theta, problem.row, record.sampling_time, typical) for record in held)
