"""Torques of any shape along one variable of the motion, as generalised forces: hats over knots, each a column.

A curve may multiply the direction of motion or the speed, as friction that depends on a place or a time does, or the
acceleration, the twist or the torque, as an inertia, a stiffness and a torque constant that depend on a place do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from robotid.diagnosis.misfit.curve import (
    BY_ACCELERATION,
    BY_DIRECTION,
    BY_SPEED,
    BY_TORQUE,
    BY_TWIST,
    IN_PROPORTION,
)
from robotid.diagnosis.nonparametric.settings import CURVES
from robotid.diagnosis.scoring.measured_motion import as_measured
from robotid.model.array import Array
from robotid.model.physical import TURN
from robotid.model.port import Port
from robotid.model.units import on_axis
from robotid.signals.record import Record
from robotid.simulation.first_guess import measured_guess
from robotid.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Variable:
    """Something along which a torque may be ordered. counted : as in `Curve.along`, or as it is; gear : the torque acts
    on the gear rather than on the motor; split : it may jump at zero; turn : it starts again after each turn."""

    along: str
    unit: str
    counted: str = ""
    gear: bool = False
    split: bool = False
    turn: bool = False


VARIABLES = (
    Variable("dphi_m", "rad/s", split=True),
    Variable("phi_m", "rad"),
    Variable("phi_m", "rad", BY_DIRECTION),
    Variable("phi_m", "rad", BY_SPEED),
    Variable("phi_m", "rad", BY_ACCELERATION),
    Variable("phi_m", "rad", BY_TWIST, gear=True),
    Variable("phi_m mod 2 pi", "rad", BY_TORQUE, turn=True),
    Variable("t", "s"),
    Variable("t", "s", BY_DIRECTION),
    Variable("t", "s", BY_SPEED),
    Variable("twist", "rad", gear=True),
    Variable("dtwist", "rad/s", gear=True),
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


def at_measured_speed(trajectory: Trajectory, record: Record) -> Trajectory:
    """A trajectory with the motor's motion as it was measured: there the unknown torque acted."""
    kept = as_measured(trajectory, record)
    return replace(kept, dphi_m=measured_guess(kept.joint, kept.theta, record)[kept.joint.motor_speed])


def variables(trajectory: Trajectory) -> list[Variable]:
    """Those that the joint has and that vary, in the units of its axis."""
    linear = trajectory.joint.structure.linear
    turns, unit = not linear and np.ptp(trajectory.phi_m) > TURN, on_axis(linear=linear)

    def is_there(variable: Variable) -> bool:
        known = (turns or not variable.turn) and (trajectory.joint.masses > 1 or not variable.gear)
        return known and bool(np.ptp(_ends(_signals(trajectory, variable)[0])) > 0.0)

    return [replace(variable, unit=unit(variable.unit)) for variable in VARIABLES if is_there(variable)]


def basis_along(trajectories: Sequence[Trajectory], variable: Variable, count: int) -> Basis:
    """Curves of so many knots, evenly spaced over where the motions are."""
    knots = _knots(np.concatenate([_signals(t, variable)[0] for t in trajectories]), variable, count)
    return basis_at(knots, trajectories, variable)


def basis_at(knots: Array, trajectories: Sequence[Trajectory], variable: Variable) -> Basis:
    """Curves with these knots (k,)."""
    signals = [_signals(t, variable) for t in trajectories]
    hats = [_hats(x, knots, variable) * factor for x, factor in signals]
    forces = tuple(_on_joint(t, h, variable) for t, h in zip(trajectories, hats, strict=True))
    size = float(np.sqrt(np.mean(np.concatenate([factor for _, factor in signals]) ** 2)))
    seen = np.stack([np.count_nonzero(h, axis=1) for h in hats]).sum(axis=0).astype(np.float64)
    return Basis(variable, knots, forces, size, seen)


def torques(basis: Basis, trajectory: Trajectory, values: Array) -> dict[Port, Array]:
    """A curve with these values (k,) as torques at every sample of another trajectory [Nm], (n,) at each port."""
    x, factor = _signals(trajectory, basis.variable)
    torque = values @ _hats(x, basis.knots, basis.variable) * factor
    return {port: share * torque for port, share in _shares(trajectory, basis.variable).items()}


def _signals(t: Trajectory, variable: Variable) -> tuple[Array, Array]:
    """The variable, and what its curve multiplies, (n,) each."""
    x = _signal(t, variable.along)
    if variable.counted == BY_DIRECTION:
        return x, np.sign(t.dphi_m)
    return x, _signal(t, IN_PROPORTION[variable.counted]) if variable.counted else np.ones(len(x))


def _signal(t: Trajectory, name: str) -> Array:
    """A variable of the motion, (n,)."""
    if name == "phi_m mod 2 pi":
        return np.asarray(t.phi_m % TURN)
    return np.asarray(t.u if name == "tau_m" else getattr(t, name))


def _ends(x: Array) -> Array:
    """Where the outermost knots of a variable (n,) are, (2,); equal where it rests but for a few samples."""
    return np.asarray(np.percentile(x, [CURVES.edge_percent, 100 - CURVES.edge_percent]))


def _knots(x: Array, variable: Variable, count: int) -> Array:
    low, high = _ends(x)
    if not high > low:
        return np.zeros(0)
    if variable.turn:
        return np.linspace(0.0, TURN, count, endpoint=False)
    if not variable.split or low >= 0 or high <= 0:
        return np.linspace(low, high, count)
    return np.concatenate([np.linspace(low, 0.0, count // 2), np.linspace(0.0, high, count // 2)])


def sides(knots: Array) -> list[slice]:
    """The knots (k,) before and behind a jump, which a knot that is there twice stands for; all where there is none."""
    jumps = [int(k) + 1 for k in np.flatnonzero(np.diff(knots) == 0.0)]
    return [slice(*ends) for ends in pairwise([0, *jumps, len(knots)])]


def _hats(x: Array, knots: Array, variable: Variable) -> Array:
    """Piecewise linear basis (knots, n), each side of a jump at zero for itself."""
    period = TURN if variable.turn else None
    found = [
        np.stack([np.interp(x, knots[at], unit, period=period) for unit in np.eye(len(knots[at]))])
        for at in sides(knots)
    ]
    return found[0] if len(found) == 1 else np.concatenate([found[0] * (x < 0), found[1] * (x > 0)])


def _on_joint(trajectory: Trajectory, basis: Array, variable: Variable) -> Array:
    """Generalised forces (nv, k, n) of applied torques, means over the intervals."""
    joint = trajectory.joint
    mean = (basis + np.concatenate([basis[:, 1:], basis[:, -1:]], axis=1)) / 2
    forces = np.zeros((joint.masses, *mean.shape))
    for j, share in enumerate(_shares(trajectory, variable).values()):
        forces[j] = share * mean
    return forces


def _shares(trajectory: Trajectory, variable: Variable) -> dict[Port, float]:
    """Of a curve that acts on each coordinate, in the order of these."""
    return {Port.MOTOR: trajectory.joint.ratio, Port.ARM: -1.0} if variable.gear else {Port.MOTOR: 1.0}


def applied(basis: Basis, trajectory: Trajectory, values: Array) -> Array:
    """A curve with these values (k,) as generalised forces on another trajectory, (nv, n)."""
    x, factor = _signals(trajectory, basis.variable)
    forces = _on_joint(trajectory, _hats(x, basis.knots, basis.variable) * factor, basis.variable)
    return np.asarray(np.einsum("ikn,k->in", forces, values))
