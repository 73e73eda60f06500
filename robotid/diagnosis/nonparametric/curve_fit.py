"""What no effect of the catalogue explains: a torque free to take any shape along one variable of the motion.

The shape is a piecewise linear curve, each of its knots a column through the joint as those of candidates are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import linprog

from robotid.diagnosis.misfit.location import BY_SPEED, Curve
from robotid.diagnosis.noise.whitening import whitened_energy
from robotid.diagnosis.nonparametric.basis import (
    Basis,
    Variable,
    applied,
    at_measured_speed,
    basis_along,
    basis_at,
    variables,
)
from robotid.diagnosis.nonparametric.curve_term import FreeCurve, can_act, with_curve
from robotid.diagnosis.refit.refitted_model import EvaluationData, RefittedModel
from robotid.diagnosis.scoring.score_test import Projected, beyond, project, scan, scans
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory

COARSE, FINE = 12, (24, 48)  # knots; of the finalists as many as the residual asks for
FADED, RIDGE = 0.03, 1e-9  # energy of a curve that is left, over the whole, where the fit may have taken it
FINALISTS = 2
SWEEPS = 4  # of a curve that acts
SETTLED = 1e-3  # of what a curve explains: a sweep that gains less is the last
PRIOR = 0.5  # of the torque's RMS: as large as a missing torque is likely to be


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A free curve that was fitted. energy, held_energy : of the whitened residuals that it explains on the fitted
    records and on those held out; values (k,) : at the knots, as fitted; moved : how far the fitted parameters go
    with it."""

    basis: Basis
    curve: Curve
    energy: float
    values: Array
    moved: Array
    held_energy: float = np.nan

    @property
    def variable(self) -> Variable:
        """Along which it lies."""
        return self.basis.variable


def shapes(trial: RefittedModel, bench: EvaluationData) -> list[Shape]:
    """The curves that explain most of what a model leaves, best first; all variables are seen coarsely before."""
    kept = _measured(trial, bench)
    coarse = _along(kept, trial, bench, variables(kept[0]), [COARSE])
    return _along(kept, trial, bench, [one.variable for one in coarse[:FINALISTS]], FINE)


def acting_along(variable: Variable, trial: RefittedModel, bench: EvaluationData) -> Shape:
    """The curve along a variable as it is once it acts."""
    return in_motion(_along(_measured(trial, bench), trial, bench, [variable], FINE)[0], trial, bench)


def _measured(trial: RefittedModel, bench: EvaluationData) -> tuple[Trajectory, ...]:
    return tuple(map(at_measured_speed, trial.motions.fitted, bench.fitted))


def _along(
    kept: Sequence[Trajectory],
    trial: RefittedModel,
    bench: EvaluationData,
    chosen: Sequence[Variable],
    counts: Sequence[int],
) -> list[Shape]:
    """A curve along each variable, best first, of as many knots as the Bayesian information criterion asks for."""
    n = bench.samples

    def criterion(shape: Shape) -> float:
        return n * float(np.log(max(trial.energy - shape.energy, 1e-9))) + len(shape.values) * float(np.log(n))

    found = _fit(trial, bench, [basis_along(kept, v, count) for v in chosen for count in counts])
    best: dict[Variable, Shape] = {}
    for shape in sorted(found, key=criterion):
        best.setdefault(shape.variable, shape)
    return list(best.values())


def in_motion(shape: Shape, trial: RefittedModel, bench: EvaluationData) -> Shape:
    """The curve as it is once it acts: what is still left asks for changes of it, and the records held out are
    simulated with it. Where it cannot act, or only does harm, the first look stays."""
    joint = trial.problem.joint
    if not can_act(shape.variable, joint):
        return _held_out(shape, trial, bench)
    whole = whitened_energy(trial.residuals, bench.whiten)
    whole_held = whitened_energy(trial.held_residuals, bench.whiten_held)
    best, now, after = None, shape, trial
    for _ in range(SWEEPS):
        try:
            after = with_curve(joint, after, bench, FreeCurve(now.variable, now.basis.knots, now.values), now.moved)
        except NumericsError:
            break
        explained = whole - after.energy
        gained = explained - (0.0 if best is None else best.energy)
        if gained <= 0.0:
            break
        best = replace(now, energy=explained, held_energy=whole_held - after.held_energy)
        if gained < SETTLED * explained:
            break
        now = _fit(after, bench, [basis_at(now.basis.knots, _measured(after, bench), now.variable)], now.values)[0]
    return best or _held_out(shape, trial, bench)


def _held_out(shape: Shape, trial: RefittedModel, bench: EvaluationData) -> Shape:
    """The curve with what it explains on the records held out, their first states free."""
    explained, p = 0.0, trial.problem
    for segment, whiten in zip(trial.held_segments, bench.whiten_held, strict=True):
        force = applied(shape.basis, at_measured_speed(segment.trajectory, segment.record), shape.values)
        one = scan(segment, bench.output, p.columns, p.free_states, (), force[:, None])
        signals = whiten(one.signals)
        first, known, answer, left = signals[: one.states], signals[one.states : -2], signals[-2], signals[-1]
        less = left - answer - shape.moved @ known
        explained += _energy(beyond(left, first)) - _energy(beyond(less, first))
    return replace(shape, held_energy=explained)


def _energy(signal: Array) -> float:
    return float(signal @ signal)


def free_forces(trajectory: Trajectory, record: Record) -> Array:
    """Generalised forces (nv, k, n) of coarse curves along all variables."""
    kept = at_measured_speed(trajectory, record)
    bases = [basis_along((kept,), variable, COARSE) for variable in variables(kept)]
    return np.concatenate([basis.forces[0] for basis in bases], axis=1)


def _fit(
    trial: RefittedModel, bench: EvaluationData, bases: Sequence[Basis], acting: Array | float = 0.0
) -> list[Shape]:
    """Each basis by itself to the residual, all columns in one solve, best first. acting : values of the curve that
    acts already."""
    p = trial.problem
    forces = [np.concatenate(parts, axis=1) for parts in zip(*(basis.forces for basis in bases), strict=True)]
    projected = project(scans(trial.segments, bench.output, p.columns, p.free_states, (), forces), bench.whiten)
    torque = PRIOR * float(np.sqrt(np.mean(np.concatenate([r.tau_m for r in bench.fitted]) ** 2)))
    edges = np.cumsum([0, *(len(basis.knots) for basis in bases)]).tolist()
    parts = zip(bases, edges[:-1], edges[1:], strict=True)
    columns, whole = projected.missing, projected.whole
    found = [
        _with_moved(
            _shape(columns[:, i:j], whole[:, i:j], projected.residual, basis, torque, acting), projected, slice(i, j)
        )
        for basis, i, j in parts
    ]
    return sorted(found, key=lambda s: -s.energy)


def _with_moved(shape: Shape, projected: Projected, at: slice) -> Shape:
    return replace(shape, moved=projected.moved(shape.moved, at))


def _shape(columns: Array, whole: Array, residual: Array, basis: Basis, torque: float, acting: Array | float) -> Shape:
    """The curve that a residual (d,) asks for through columns (d, k), no larger than is likely. whole : the columns
    before the fitted parameters were taken out."""
    variable, knots = basis.variable, basis.knots
    covariance = np.linalg.inv(columns.T @ columns + np.eye(len(knots)) * (basis.size / torque) ** 2)
    values = covariance @ (columns.T @ residual)
    at = basis.size if variable.counted == BY_SPEED else 1.0
    curve = Curve(
        along=f"{variable.along},{variable.counted}" if variable.counted else variable.along,
        unit=variable.unit,
        x=knots,
        missing_torque=at * _sparsest(values + acting, _confounded(columns, whole)),
        spread=at * np.sqrt(np.diag(covariance)),
        count=basis.seen,
        order=0.0,
        at=at,
    )
    energy = float(residual @ residual - np.sum((residual - columns @ values) ** 2))
    return Shape(basis, curve, energy, values + acting, values)


def _confounded(columns: Array, whole: Array) -> Array:
    """Curves (m, k) of which the fitted parameters leave next to nothing: the fit may have taken or added them."""
    ridge = RIDGE * float(np.trace(whole.T @ whole)) * np.eye(whole.shape[1])
    left, vectors = eigh(columns.T @ columns, whole.T @ whole + ridge)
    return np.asarray(vectors[:, left < FADED].T)


def _sparsest(values: Array, free: Array) -> Array:
    """Of all curves values + a free, the one of least absolute sum: what is not needed is zero."""
    m, k = free.shape
    cost = np.concatenate([np.zeros(m), np.ones(k)])
    limits = np.block([[free.T, -np.eye(k)], [-free.T, -np.eye(k)]])
    scale = max(float(np.abs(values).max()), 1e-300)
    bounds = [(None, None)] * m + [(0.0, None)] * k
    found = linprog(cost, limits, np.concatenate([-values, values]) / scale, bounds=bounds)
    return values if found.x is None else np.asarray(values + scale * (found.x[:m] @ free))
