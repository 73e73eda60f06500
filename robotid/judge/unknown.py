"""What no effect of the catalogue explains: a torque free to take any shape along one variable of the motion.

The shape is a piecewise linear curve, each of its knots a column through the joint as those of candidates are. It may
multiply the direction of motion or the speed, as friction that depends on a place or a time does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import linprog

from robotid.errors import NumericsError
from robotid.judge.columns import with_angle
from robotid.judge.free_curve import FreeCurve, with_curve
from robotid.judge.location import BY_DIRECTION, BY_SPEED, Curve
from robotid.judge.score import Projected, project, scan
from robotid.judge.trial import Bench, Trial
from robotid.judge.whitening import Whitening
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulate.simulate import Trajectory, measured_guess

KNOTS, COARSE = 24, 12
FADED, RIDGE = 0.03, 1e-9  # energy of a curve that is left, over the whole, where the fit may have taken it
FINALISTS = 2  # seen with all knots
SWEEPS = 3  # of a curve that acts
EDGE = 0.5  # per cent of the samples beyond the first and the last knot
PRIOR = 0.5  # of the torque's RMS: as large as a missing torque is likely to be


@dataclass(frozen=True, slots=True)
class Variable:
    """Something along which a torque may be ordered. counted : as in `Curve.along`, by direction, by speed or as it is;
    turns : the torque acts on the gear rather than on the motor; split : it may jump at zero."""

    along: str
    unit: str
    counted: str = ""
    gear: bool = False
    split: bool = False


VARIABLES = (
    Variable("dphi_m", "rad/s", split=True),
    Variable("phi_m", "rad"),
    Variable("phi_m", "rad", BY_DIRECTION),
    Variable("phi_m", "rad", BY_SPEED),
    Variable("t", "s"),
    Variable("t", "s", BY_DIRECTION),
    Variable("t", "s", BY_SPEED),
    Variable("twist", "rad", gear=True),
    Variable("ddphi_m", "rad/s2"),
    Variable("tau_m", "Nm"),
    Variable("tau_m", "Nm", BY_DIRECTION),
)


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Curves along a variable with these knots (k,), as generalised forces (nv, k, n) of every record. size : RMS of
    what the curve multiplies; seen (k,) : samples near each knot."""

    variable: Variable
    knots: Array
    forces: tuple[Array, ...]
    size: float
    seen: Array


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


def shapes(trial: Trial, bench: Bench) -> list[Shape]:
    """The curves that explain most of what a model leaves, best first; all variables are seen coarsely before."""
    kept = tuple(map(_as_measured, trial.trajectories, bench.fitted))
    coarse = _fit(trial, bench, [_basis(kept, v, COARSE) for v in _variables(kept[0])])
    fine = [_fit(trial, bench, [_basis(kept, one.variable, KNOTS)])[0] for one in coarse[:FINALISTS]]
    return sorted(fine, key=lambda s: -s.energy)


def in_motion(shape: Shape, trial: Trial, bench: Bench) -> Shape:
    """The curve as it is once it acts: what is still left asks for changes of it, and the records held out are
    simulated with it. Along all but the speed the first look does."""
    if shape.variable.along != "dphi_m":
        return _held_out(shape, trial, bench)
    whole, whole_held = _seen(trial.residuals, bench.whiten), _seen(trial.held_residuals, bench.whiten_held)
    best, now = None, shape
    for _ in range(SWEEPS):
        try:
            after = with_curve(trial, bench, FreeCurve(now.basis.knots, now.values), now.moved)
        except NumericsError:
            break
        explained = whole - after.energy
        if best is not None and explained <= best.energy:
            break
        best = replace(now, energy=explained, held_energy=whole_held - after.held_energy)
        now = _fit(after, bench, [now.basis], now.values)[0]
    return best or _held_out(shape, trial, bench)


def _held_out(shape: Shape, trial: Trial, bench: Bench) -> Shape:
    """The curve with what it explains on the records held out, their first states free."""
    explained, p = 0.0, trial.problem
    held = zip(trial.held_trajectories, bench.held, trial.held_residuals, bench.whiten_held, strict=True)
    for t, record, residual, whiten in held:
        kept = _as_measured(t, record)
        x, factor = _signals(kept, shape.variable)
        force = np.einsum(
            "ikn,k->in", _on_joint(kept, _hats(x, shape.basis.knots) * factor, shape.variable), shape.values
        )
        one = scan(t, record, residual, bench.output, p.columns, p.free_states, (), force[:, None])
        signals = whiten(one.signals)
        first, known, answer, left = signals[: one.states], signals[one.states : -2], signals[-2], signals[-1]
        less = left - answer - shape.moved @ known
        basis = np.linalg.qr(first.T)[0]
        explained += _energy(left - basis @ (basis.T @ left)) - _energy(less - basis @ (basis.T @ less))
    return replace(shape, held_energy=explained)


def _seen(residuals: Sequence[Array], whitenings: Sequence[Whitening]) -> float:
    """Energy of residuals as a bench sees them, which need not be that of the trial's own."""
    return sum(_energy(whiten(r)) for whiten, r in zip(whitenings, residuals, strict=True))


def _energy(signal: Array) -> float:
    return float(signal @ signal)


def free_forces(trajectory: Trajectory, record: Record) -> Array:
    """Generalised forces (nv, k, n) of coarse curves along all variables."""
    kept = _as_measured(trajectory, record)
    bases = [_basis((kept,), variable, COARSE) for variable in _variables(kept)]
    return np.concatenate([basis.forces[0] for basis in bases], axis=1)


def _as_measured(trajectory: Trajectory, record: Record) -> Trajectory:
    """A trajectory with the motor's motion as it was measured: there the unknown torque acted."""
    kept = with_angle(trajectory)
    speed = measured_guess(kept.joint, kept.theta, record)[kept.joint.speeds.start]
    return replace(kept, phi_m=record.phi_m, dphi_m=speed)


def _variables(trajectory: Trajectory) -> list[Variable]:
    """Those that the joint has and that vary."""
    flexible = trajectory.joint.masses > 1
    return [v for v in VARIABLES if (flexible or not v.gear) and np.ptp(_signals(trajectory, v)[0]) > 0.0]


def _basis(trajectories: Sequence[Trajectory], variable: Variable, count: int) -> Basis:
    signals = [_signals(t, variable) for t in trajectories]
    knots = _knots(np.concatenate([x for x, _ in signals]), variable, count)
    hats = [_hats(x, knots) * factor for x, factor in signals]
    forces = tuple(_on_joint(t, h, variable) for t, h in zip(trajectories, hats, strict=True))
    size = float(np.sqrt(np.mean(np.concatenate([factor for _, factor in signals]) ** 2)))
    seen = np.stack([np.count_nonzero(h, axis=1) for h in hats]).sum(axis=0).astype(np.float64)
    return Basis(variable, knots, forces, size, seen)


def _fit(trial: Trial, bench: Bench, bases: Sequence[Basis], acting: Array | float = 0.0) -> list[Shape]:
    """Each basis by itself to the residual, all columns in one solve, best first. acting : values of the curve that
    acts already."""
    p, scans = trial.problem, []
    cases = zip(trial.trajectories, bench.fitted, trial.residuals, strict=True)
    for k, (t, record, residual) in enumerate(cases):
        forces = np.concatenate([basis.forces[k] for basis in bases], axis=1)
        scans.append(scan(t, record, residual, bench.output, p.columns, p.free_states, (), forces))
    projected = project(scans, bench.whiten)
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


def _signals(t: Trajectory, variable: Variable) -> tuple[Array, Array]:
    """The variable, and what its curve multiplies, (n,) each."""
    speed = t.dphi_m
    time = t.begin + np.arange(len(t.u)) * t.sampling_time
    known = {"dphi_m": speed, "phi_m": t.phi_m, "t": time, "tau_m": t.u, "twist": t.twist, "ddphi_m": None}
    x = t.ddphi_m if variable.along == "ddphi_m" else known[variable.along]
    factor = {"": np.ones_like(speed), BY_DIRECTION: np.sign(speed), BY_SPEED: speed}[variable.counted]
    return np.asarray(x), factor


def _knots(x: Array, variable: Variable, count: int) -> Array:
    low, high = np.percentile(x, [EDGE, 100 - EDGE])
    if not high > low:
        return np.zeros(0)
    if not variable.split or low >= 0 or high <= 0:
        return np.linspace(low, high, count)
    return np.concatenate([np.linspace(low, 0.0, count // 2), np.linspace(0.0, high, count // 2)])


def _hats(x: Array, knots: Array) -> Array:
    """Piecewise linear basis (knots, n); a knot that is there twice is one on either side of a jump."""
    twice = np.flatnonzero(np.diff(knots) == 0.0)
    if not twice.size:
        return np.stack([np.interp(x, knots, unit) for unit in np.eye(len(knots))])
    k = int(twice[0]) + 1
    return np.concatenate([_hats(x, knots[:k]) * (x < 0), _hats(x, knots[k:]) * (x > 0)])


def _on_joint(trajectory: Trajectory, basis: Array, variable: Variable) -> Array:
    """Generalised forces (nv, k, n) of applied torques, means over the intervals."""
    joint = trajectory.joint
    mean = (basis + np.concatenate([basis[:, 1:], basis[:, -1:]], axis=1)) / 2
    forces = np.zeros((joint.masses, *mean.shape))
    for j, c in ((0, joint.ratio), (1, -1.0)) if variable.gear else ((0, 1.0),):
        forces[j] = c * mean
    return forces


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
