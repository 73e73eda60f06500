"""What no effect of the catalogue explains: a torque free to take any shape along one variable of the motion.

The shape is a piecewise linear curve, each of its knots a column through the joint as those of candidates are. It may
multiply the direction of motion or the speed, as friction that depends on a place or a time does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from robotid.judge.columns import with_angle
from robotid.judge.location import BY_DIRECTION, BY_SPEED, Curve
from robotid.judge.score import Projected, project, scan
from robotid.judge.trial import Bench, Trial
from robotid.model.array import Array
from robotid.simulate.simulate import Trajectory

KNOTS, COARSE = 24, 12
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
class Shape:
    """A free curve that was fitted. energy : of the whitened residual that it explains; knots (k,) used."""

    variable: Variable
    curve: Curve
    energy: float
    knots: int


def shapes(trial: Trial, bench: Bench, variables: Sequence[Variable] = VARIABLES) -> list[Shape]:
    """The best curve along each variable for what a model leaves, best first."""
    flexible = trial.problem.joint.masses > 1
    found = [_shape(trial, bench, v) for v in variables if flexible or not v.gear]
    return sorted((s for s in found if s is not None), key=lambda s: -s.energy)


def free_forces(trajectory: Trajectory) -> Array:
    """Generalised forces (nv, k, n) of coarse curves along all variables."""
    trajectory, found = with_angle(trajectory), []
    for variable in VARIABLES:
        if variable.gear and trajectory.joint.masses == 1:
            continue
        x, factor = _signals(trajectory, variable)
        knots = _knots(x, variable, COARSE)
        if len(knots):
            found.append(_on_joint(trajectory, _hats(x, knots) * factor, variable))
    return np.concatenate(found, axis=1)


def _shape(trial: Trial, bench: Bench, variable: Variable) -> Shape | None:
    kept = [with_angle(t) for t in trial.trajectories]
    signals = [_signals(t, variable) for t in kept]
    knots = _knots(np.concatenate([x for x, _ in signals]), variable, KNOTS)
    if len(knots) < 3:
        return None
    hats = [_hats(x, knots) * factor for x, factor in signals]
    p, scans = trial.problem, []
    for t, record, residual, basis in zip(trial.trajectories, bench.fitted, trial.residuals, hats, strict=True):
        forces = _on_joint(t, basis, variable)
        scans.append(scan(t, record, residual, bench.output, p.columns, p.free_states, (), forces))
    projected = project(scans, bench.whiten)
    size = PRIOR * float(np.sqrt(np.mean(np.concatenate([r.tau_m for r in bench.fitted]) ** 2)))
    typical = float(np.sqrt(np.mean(np.concatenate([f for _, f in signals]) ** 2)))
    return _fitted(
        projected, knots, np.sum([np.sum(h != 0.0, axis=1) for h in hats], axis=0), variable, size / typical, typical
    )


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
    """Generalised forces (nv, k, n) of absorbed torques, means over the intervals."""
    joint = trajectory.joint
    mean = (basis + np.concatenate([basis[:, 1:], basis[:, -1:]], axis=1)) / 2
    forces = np.zeros((joint.masses, *mean.shape))
    for j, c in ((0, joint.ratio), (1, -1.0)) if variable.gear else ((0, 1.0),):
        forces[j] = -c * mean
    return forces


def _fitted(projected: Projected, knots: Array, count: Array, variable: Variable, size: float, typical: float) -> Shape:
    M, residual = projected.missing, projected.residual
    information = M.T @ M + np.eye(len(knots)) / size**2
    covariance = np.linalg.inv(information)
    values = covariance @ (M.T @ residual)
    energy = float(residual @ residual - np.sum((residual - M @ values) ** 2))
    at = typical if variable.counted == BY_SPEED else 1.0
    curve = Curve(
        along=f"{variable.along},{variable.counted}" if variable.counted else variable.along,
        unit=variable.unit,
        x=knots,
        missing_torque=at * _sparsest(values, _confounded(knots, variable)),
        spread=at * np.sqrt(np.diag(covariance)),
        count=count.astype(np.float64),
        order=0.0,
        at=at,
    )
    return Shape(variable, curve, energy, len(knots))


def _confounded(knots: Array, variable: Variable) -> Array:
    """Curves that the friction of the model may have taken or given, (m, k)."""
    if variable.along == "dphi_m":
        side = np.where(np.arange(len(knots)) < len(knots) // 2, -1.0, 1.0)
        return np.stack([side, knots])
    return np.ones((1, len(knots)))


def _sparsest(values: Array, free: Array) -> Array:
    """Of all curves values + a free, the one of least absolute sum: what is not needed is zero."""
    m, k = free.shape
    cost = np.concatenate([np.zeros(m), np.ones(k)])
    limits = np.block([[free.T, -np.eye(k)], [-free.T, -np.eye(k)]])
    scale = max(float(np.abs(values).max()), 1e-300)
    bounds = [(None, None)] * m + [(0.0, None)] * k
    found = linprog(cost, limits, np.concatenate([-values, values]) / scale, bounds=bounds)
    return values if found.x is None else np.asarray(values + scale * (found.x[:m] @ free))
