"""Equations of motion of several joints whose arms a body couples, as one mechanism.

Every joint keeps its own effects. The body takes the torque w = -(M(q) a + h(q, dq)) from the arms, whose
accelerations a = a0 + g w follow from those without a body, a0, and from what the arms' own masses let a torque do, g:

    (1 + M g) w = -(M a0 + h) .
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, Index, Mask
from robotid.model.derivatives import DerivativeColumns, Parts
from robotid.model.geometry import Selection, coordinates, position
from robotid.model.joint import Dynamics, EdgeDistances, Joint
from robotid.model.linear_algebra import product, solve
from robotid.model.linear_part import LinearPart
from robotid.model.port import Port
from robotid.model.signal_matrix import Rows
from robotid.simulation.coupled.planar_chain import BodyTorque, PlanarChain

ARM, MOTOR = 0, 1  # columns of the derivatives of one joint that are wanted


@dataclass(frozen=True, slots=True, eq=False)
class _Axis:
    """Where a joint's own things are: rows of the common state, of its directions of motion and of its sides in the
    common mode, and its slice of theta. angle : of its arm, a sum over its own states; row : its own state that is the
    speed of the mass that bears the arm, which turns `lever` times as fast as that mass."""

    joint: Joint
    rows: Index
    coordinates: Index
    sides: Index
    at: slice
    angle: Selection
    row: int
    lever: float

    def modes(self, s: Array, masses: int) -> Array:
        """Its own rows of the common mode s, which may lack the sides."""
        own = self.coordinates if len(s) == masses else np.concatenate([self.coordinates, self.sides])
        return np.asarray(s[own])

    @property
    def columns(self) -> DerivativeColumns:
        """To a torque on the mass that bears the arm, and to the motor torque."""
        return DerivativeColumns(forces=(self.row - self.joint.speeds.start,))


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """All axes at n points. each : their own dynamics without a body. M g as of the module; q, dq, w : (k, n)."""

    each: tuple[Dynamics, ...]
    body: BodyTorque
    freedom: Array
    w: Array


class CoupledJoints:
    """The mechanism of several joints and the body that they bear; a `Mechanism`.

    Every joint keeps its angle, and its arm has an inertia of its own, however small, besides the body's. State: the
    positions of all axes, then all speeds, then all memory. theta : the parameters of all joints in a row; u : (n,
    axes). Two arms with dry friction of their own that rest at the same instant break away one by one.
    """

    def __init__(self, joints: Sequence[Joint], body: PlanarChain) -> None:
        self.joints, self.body = tuple(joints), body
        self.masses, self.edges = (sum(counts) for counts in zip(*((j.masses, j.edges) for j in joints), strict=True))
        flows = sum(j.speeds.start for j in joints)
        self.speeds = slice(flows, flows + self.masses)
        self.nx = sum(j.nx for j in joints)
        self._axes = tuple(self._lay_out())
        self.dry = tuple(int(axis.coordinates[j]) for axis in self._axes for j in axis.joint.dry)

    def _lay_out(self) -> list[_Axis]:
        flow, speed, memory, side, theta = 0, self.speeds.start, self.speeds.stop, self.masses, 0
        axes = []
        for joint in self.joints:
            flows, masses, memories = joint.speeds.start, joint.masses, joint.nx - joint.speeds.stop
            parts = [(flow, flows), (speed, masses), (memory, memories)]
            rows = np.concatenate([np.arange(first, first + count) for first, count in parts])
            first, parameters = speed - self.speeds.start, len(joint.names)
            ((coordinate, lever),) = coordinates(Port.ARM, masses, joint.ratio)
            axes.append(
                _Axis(
                    joint,
                    rows,
                    np.arange(first, first + masses),
                    np.arange(side, side + joint.edges),
                    slice(theta, theta + parameters),
                    position(Port.ARM, masses, joint.ratio),
                    joint.speeds.start + coordinate,
                    lever,
                )
            )
            flow, speed, memory = flow + flows, speed + masses, memory + memories
            side, theta = side + joint.edges, theta + parameters
        return axes

    @property
    def state_limits(self) -> Mapping[int, float]:
        """What the size of a state cannot exceed, by row, where that is known."""
        return {int(axis.rows[row]): limit for axis in self._axes for row, limit in axis.joint.state_limits.items()}

    def linear_at(self, theta: Array) -> tuple[LinearPart, ...]:
        """What of the equations of each joint is the same at every sample."""
        return tuple(axis.joint.linear_at(theta[axis.at]) for axis in self._axes)

    @property
    def motor_columns(self) -> DerivativeColumns:
        """What derivatives to the torques of all motors are columns of."""
        return DerivativeColumns(forces=tuple(int(axis.coordinates[0]) for axis in self._axes))

    def rows(self, axis: int) -> Index:
        """Rows of the common state that are one joint's."""
        return self._axes[axis].rows

    def arms(self, x: Array) -> tuple[Array, Array]:
        """Angles and speeds of all arms, (k, n) each."""
        angles = [sum(c * x[axis.rows[j]] for j, c in axis.angle) for axis in self._axes]
        speeds = [axis.lever * x[axis.rows[axis.row]] for axis in self._axes]
        return np.array(angles), np.array(speeds)

    def directions(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Directions of motion s (nv, n) and, below them, the sides of all edges."""
        if not self.edges:
            return s
        found = np.concatenate([s[: self.masses], np.empty((self.edges, s.shape[1]))])
        for axis in self._axes:
            if axis.joint.edges:
                own = axis.joint.directions(x[axis.rows], s[axis.coordinates], t, theta[axis.at])
                found[axis.sides] = own[axis.joint.masses :]
        return found

    def distances(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Distances of all edges, (edges, n)."""
        found = [
            axis.joint.distances(x[axis.rows], axis.modes(s, self.masses), t, theta[axis.at])
            for axis in self._axes
            if axis.joint.edges
        ]
        return np.concatenate(found) if found else np.zeros((0, x.shape[1]))

    def distance_slopes(
        self, x: Array, s: Array, t: Array, theta: Array, columns: DerivativeColumns | None = None
    ) -> EdgeDistances:
        """Distances of all edges with their derivatives to the states; no torque moves an edge at once."""
        n = x.shape[1]
        value, to_states = np.zeros((self.edges, n)), np.zeros((self.edges, self.nx, n))
        for axis in self._axes:
            if axis.joint.edges:
                own = axis.joint.distance_slopes(x[axis.rows], axis.modes(s, self.masses), t, theta[axis.at])
                at = axis.sides - self.masses
                value[at], to_states[np.ix_(at, axis.rows)] = own.value, own.to_states
        return EdgeDistances(value, to_states, None if columns is None else np.zeros((self.edges, columns.width, n)))

    def force(
        self,
        x: Array,
        u: Array,
        s: Array,
        t: Array,
        theta: Array,
        linear: tuple[LinearPart, ...] | None = None,
    ) -> Array:
        """Generalised force on every mass, (nv, n); where the body acts, what moves the mass as it does amid all
        others."""
        found = np.empty((self.masses, x.shape[1]))
        motion = self._motion(x, u, s, t, theta)
        for k, axis in enumerate(self._axes):
            acting = x[axis.rows], u[:, k], axis.modes(s, self.masses), t, theta[axis.at]
            own = axis.joint.force(*acting, None if linear is None else linear[k])
            own[axis.row - axis.joint.speeds.start] += axis.lever * motion.w[k]
            found[axis.coordinates] = own
        return found

    def evaluate(
        self,
        x: Array,
        u: Array,
        s: Array,
        t: Array,
        theta: Array,
        sticking: Mask | None = None,
        columns: DerivativeColumns | None = None,
        linear: Sequence[LinearPart] | None = None,
    ) -> Dynamics:
        """Right-hand side and its derivatives. columns : None, or `motor_columns`; the last of these, the one motor
        torque of a joint, is empty."""
        motion = self._motion(x, u, s, t, theta, sticking, linear)
        to_states, to_torques = self._body_slopes(motion, x.shape[1])
        f = np.empty((self.nx, x.shape[1]))
        states: Rows = [{} for _ in range(self.nx)]
        torques: Rows = [{} for _ in range(self.nx)]
        for k, (axis, own) in enumerate(zip(self._axes, motion.each, strict=True)):
            assert own.to_columns is not None
            for row, place in enumerate(axis.rows.tolist()):
                f[place] = own.f[row]
                states[place] = {int(axis.rows[j]): value for j, value in own.to_states[row].items()}
                gain, driven = (own.to_columns[row].get(column) for column in (ARM, MOTOR))
                if driven is not None:
                    torques[place][k] = driven
                if gain is not None:
                    f[place] += axis.lever * gain * motion.w[k]
                    _add_dense(states[place], axis.lever * gain, to_states[k])
                    _add_dense(torques[place], axis.lever * gain, to_torques[k])
        if columns is None:
            return Dynamics(f, states, None, 0)
        return Dynamics(f, states, torques, columns.width)

    def _motion(
        self,
        x: Array,
        u: Array,
        s: Array,
        t: Array,
        theta: Array,
        sticking: Mask | None = None,
        linear: Sequence[LinearPart] | None = None,
    ) -> _Motion:
        """All axes, and the torques w that the body gives to them."""
        n, k = x.shape[1], len(self.joints)
        each, freedom, bare = [], np.zeros((k, n)), np.empty((k, n))
        for i, axis in enumerate(self._axes):
            own = axis.joint.evaluate(
                x[axis.rows],
                u[:, i],
                axis.modes(s, self.masses),
                t,
                theta[axis.at],
                None if sticking is None else sticking[axis.coordinates],
                axis.columns,
                None if linear is None else linear[i],
            )
            assert own.to_columns is not None
            each.append(own)
            freedom[i] = axis.lever**2 * np.asarray(own.to_columns[axis.row].get(ARM, 0.0))
            bare[i] = axis.lever * own.f[axis.row]
        q, dq = self.arms(x)
        load = self.body.torque(q, dq, bare)
        w = -solve(_factor(self.body.mass(q), freedom), load[:, None])[:, 0]
        body = self.body.linearise(q, dq, bare + freedom * w)
        return _Motion(tuple(each), body, freedom, w)

    def _body_slopes(self, motion: _Motion, n: int) -> tuple[Array, Array]:
        """Derivatives of the body's torques w to all states (k, nx, n) and to the motor torques (k, axes, n)."""
        k, body = len(self.joints), motion.body
        bare, by_motors = np.zeros((k, self.nx, n)), np.zeros((k, k, n))
        turned = np.zeros((k, self.nx, n))
        for i, (axis, own) in enumerate(zip(self._axes, motion.each, strict=True)):
            assert own.to_columns is not None
            for j, value in own.to_states[axis.row].items():
                bare[i, axis.rows[j]] = axis.lever * value
            by_motors[i, i] = axis.lever * np.asarray(own.to_columns[axis.row].get(MOTOR, 0.0))
            for j, c in axis.angle:
                turned[:, axis.rows[j]] += c * body.to_angles[:, i]
            turned[:, axis.rows[axis.row]] += axis.lever * body.to_speeds[:, i]
        load = np.concatenate([product(body.mass, bare) + turned, product(body.mass, by_motors)], axis=1)
        slopes = -solve(_factor(body.mass, motion.freedom), load)
        return slopes[:, : self.nx], slopes[:, self.nx :]


def _factor(mass: Array, freedom: Array) -> Array:
    """1 + M g, (k, k, n)."""
    factor = mass * freedom[None]
    factor[np.arange(len(mass)), np.arange(len(mass))] += 1.0
    return factor


def _add_dense(row: Parts, factor: Array | float, slopes: Array) -> None:
    """Add a multiple of derivatives (columns, n) to a row, in place."""
    for j, slope in enumerate(slopes):
        row[j] = row.get(j, 0.0) + factor * slope
