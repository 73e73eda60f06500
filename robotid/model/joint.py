"""A joint: terms at ports, summed by virtual work into equations of motion and their exact derivatives.

Coordinates q are the angles (phi_m, phi_a, phi_b), as many as there are masses. The state is
x = (positions, speeds, memory): positions are the twists of gear and link, and phi_m where anything reads it;
speeds are dq; memory the states of the terms. Twists are states of their own because they are a thousand times smaller
than the angles they are the difference of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.errors import ConfigError
from robotid.model.array import Array, Mask
from robotid.model.channel import Channel
from robotid.model.geometry import Selection, coordinates, position, rotates
from robotid.model.linear_algebra import inverse
from robotid.model.parameters import Parameter, Parameters
from robotid.model.port import Port, Signal
from robotid.model.structure import Structure
from robotid.model.term import Motion, Term
from robotid.model.units import sliding


@dataclass(frozen=True, slots=True)
class Placed:
    """A term at its port. at : slice of theta; x, v : the port's position and speed as sums over the state; q : its
    selection S of the coordinates; z : slice of its memory in the state."""

    port: Port
    term: Term
    at: slice
    x: Selection
    v: Selection
    q: Selection
    z: slice
    reads_acceleration: bool


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Right-hand side and derivatives at n points.

    f (nx, n); A = df/dx (nx, nx, n); B = df/d(theta[columns], u) (nx, k + 1, n), or None.
    """

    f: Array
    A: Array
    B: Array | None


class Joint:
    """Equations of motion of one joint, vectorised over samples.

    terms : (port, term) pairs; channels : (signal, channel) pairs; ratio : phi_a / phi_m.
    angle : keep phi_m as a state even where no effect reads it.
    """

    def __init__(
        self,
        structure: Structure,
        terms: Sequence[tuple[Port, Term]],
        channels: Sequence[tuple[Signal, Channel]] = (),
        *,
        angle: bool = False,
    ) -> None:
        self.structure = structure
        self.channels = tuple(channels)
        ports = {port for port, _ in terms}
        self.masses = 1 if not ports & {Port.GEAR, Port.LINK, Port.TOOL} else 3 if Port.TOOL in ports else 2
        if structure.gear_ratio is None and ports != {Port.MOTOR}:
            raise ConfigError("effects beyond the motor need robot.gear_ratio", where="robot.model")
        self.ratio = structure.gear_ratio or 1.0
        probes = [_probe(term) for _, term in terms]
        self.keeps_angle = angle or any(
            probe.x and port in rotates(self.masses) for (port, _), probe in zip(terms, probes, strict=True)
        )
        self._lay_out(terms, probes)
        names = [(f"{port}.{term.name}", term.parameters) for port, term in terms]
        names += [(f"{signal}.{channel.name}", channel.parameters) for signal, channel in self.channels]
        self.declared: tuple[Parameter, ...] = tuple(p for _, ps in names for p in ps)
        self.names: tuple[str, ...] = tuple(f"{name}.{p.symbol}" for name, ps in names for p in ps)

    def _lay_out(self, terms: Sequence[tuple[Port, Term]], probes: Sequence[_Reads]) -> None:
        nv, npos = self.masses, self.masses - 1 + self.keeps_angle
        memory = npos + nv
        r = self.ratio
        motion = np.array([[r, -1.0, 0.0], [0.0, 1.0, -1.0]])[: nv - 1, :nv]
        self._flow = np.vstack([motion, np.eye(1, nv)]) if self.keeps_angle else motion
        self.speeds = slice(npos, npos + nv)
        placed, theta = [], 0
        dry = np.zeros(nv, dtype=bool)
        for (port, term), probe in zip(terms, probes, strict=True):
            q = coordinates(port, nv, r)
            v = tuple((npos + j, c) for j, c in q)
            x = position(port, nv, r) if self.keeps_angle or port not in rotates(nv) else ()
            count, k = len(term.parameters), len(term.states)
            placed.append(Placed(port, term, slice(theta, theta + count), x, v, q, slice(memory, memory + k), probe.a))
            theta, memory = theta + count, memory + k
            if probe.s and len(q) == 1:
                dry[q[0][0]] = True
        self.placed = tuple(placed)
        self.dry = tuple(int(j) for j in np.flatnonzero(dry))
        self.nx, self.n_theta = memory, theta

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        positions = ("twist", "link_twist")[: self.masses - 1] + (("phi_m",) if self.keeps_angle else ())
        memory = tuple(f"{p.port}.{p.term.name}.{s}" for p in self.placed for s in p.term.states)
        return (*positions, *("dphi_m", "dphi_a", "dphi_b")[: self.masses], *memory)

    def parameters(self) -> Parameters:
        """Declared guesses and bounds, all free, terms first and then channels."""
        lower, upper = np.array([p.bounds for p in self.declared], dtype=np.float64).reshape(-1, 2).T
        values = np.array([p.guess for p in self.declared], dtype=np.float64)
        units = tuple(sliding(p.unit) if self.structure.linear else p.unit for p in self.declared)
        return Parameters(self.names, units, values, lower, upper, np.ones(len(values), dtype=bool))

    def motion(self, place: Placed, x: Array, ddq: Array | None, s: Array, t: Array) -> Motion:
        """Motion of one port at states x (nx, n), accelerations ddq (nv, n) or None for rest, directions s (nv, n)."""
        v = _sum(place.v, x)
        zero = np.zeros(1)
        a = _sum(place.q, ddq) if ddq is not None else zero
        direction = s[place.q[0][0]] * np.sign(place.q[0][1]) if len(place.q) == 1 else np.sign(v)
        return Motion(_sum(place.x, x) if place.x else zero, v, a, direction, t, x[place.z])

    def force(self, x: Array, u: Array, s: Array, t: Array, theta: Array) -> Array:
        """Generalised force B u - sum S^T tau(x, v, 0), (nv, n)."""
        return self._force([self.motion(place, x, None, s, t) for place in self.placed], u, theta)

    def _force(self, motions: Sequence[Motion], u: Array, theta: Array) -> Array:
        force = np.zeros((self.masses, len(u)))
        force[0] = u
        for place, m in zip(self.placed, motions, strict=True):
            tau = place.term.torque(m, theta[place.at].tolist())
            for j, c in place.q:
                force[j] -= c * tau
        return force

    def _mass_matrix(self, motions: Sequence[Motion], theta: Array) -> Array:
        """M = sum S^T (dtau/da) S, (nv, nv, n), or (nv, nv, 1) where it does not change."""
        mass = np.zeros((self.masses, self.masses, 1))
        for place, m in zip(self.placed, motions, strict=True):
            if place.reads_acceleration:
                a = place.term.partials(m, theta[place.at].tolist()).a
                added = np.zeros((self.masses, self.masses, np.size(a)))
                for i, ci in place.q:
                    for j, cj in place.q:
                        added[i, j] = ci * cj * a
                mass = mass + added
        return mass

    def evaluate(
        self,
        x: Array,
        u: Array,
        s: Array,
        t: Array,
        theta: Array,
        locked: Mask | None = None,
        columns: Sequence[int] | None = None,
    ) -> Dynamics:
        """Right-hand side and its derivatives.

        x : (nx, n); u : (n,) motor torque; s : (nv, n) directions of motion; t : (n,); theta : (n_theta,).
        locked : (nv, n) coordinates held at rest by friction. columns : indices into theta of the derivatives wanted.
        """
        n, nv = x.shape[1], self.masses
        motions = [self.motion(place, x, None, s, t) for place in self.placed]
        force, mass = self._force(motions, u, theta), self._mass_matrix(motions, theta)
        if locked is not None:
            force, mass = np.where(locked, 0.0, force), _hold(mass, locked)
        gain = inverse(mass)
        ddq = _times(gain, force)
        jacobian = np.zeros((nv, self.nx, n))
        response = None if columns is None else np.zeros((nv, len(columns) + 1, n))
        f, A = np.empty((self.nx, n)), np.zeros((self.nx, self.nx, n))
        B = None if columns is None else np.zeros((self.nx, len(columns) + 1, n))
        flow = len(self._flow)
        f[:flow], f[self.speeds] = self._flow @ x[self.speeds], ddq
        A[:flow, self.speeds] = self._flow[:, :, None]
        where = {} if columns is None else {c: k for k, c in enumerate(columns)}
        for place, m in zip(self.placed, motions, strict=True):
            if place.reads_acceleration:
                m = self.motion(place, x, ddq, s, t)
            self._add_torque(place, m, theta, jacobian, response, where)
            if place.term.states:
                self._add_memory(place, m, theta, f, A, B, where)
        if response is not None and B is not None:
            response[0, -1] = 1.0
        if locked is not None:
            jacobian[np.broadcast_to(locked[:, None], jacobian.shape)] = 0.0
            if response is not None:
                response[np.broadcast_to(locked[:, None], response.shape)] = 0.0
        A[self.speeds] = _times(gain, jacobian)
        if response is not None and B is not None:
            B[self.speeds] = _times(gain, response)
        return Dynamics(f, A, B)

    def _add_torque(
        self, place: Placed, m: Motion, theta: Array, jacobian: Array, response: Array | None, where: dict[int, int]
    ) -> None:
        d = place.term.partials(m, theta[place.at].tolist())
        for j, c in place.q:
            for partial, selection in ((d.x, place.x), (d.v, place.v)):
                if not _absent(partial):
                    for i, k in selection:
                        jacobian[j, i] -= c * k * partial
            for i, partial in enumerate(d.z, start=place.z.start):
                jacobian[j, i] -= c * partial
            if response is not None:
                for i, partial in enumerate(d.theta, start=place.at.start):
                    if i in where:
                        response[j, where[i]] -= c * partial

    def _add_memory(
        self, place: Placed, m: Motion, theta: Array, f: Array, A: Array, B: Array | None, where: dict[int, int]
    ) -> None:
        rates = place.term.rate(m, theta[place.at].tolist())
        for row, rate, d in zip(
            range(place.z.start, place.z.stop),
            rates,
            place.term.rate_partials(m, theta[place.at].tolist()),
            strict=True,
        ):
            f[row] = rate
            for partial, selection in ((d.x, place.x), (d.v, place.v)):
                for i, k in selection:
                    A[row, i] += k * partial
            for i, partial in enumerate(d.z, start=place.z.start):
                A[row, i] += partial
            if B is not None:
                for i, partial in enumerate(d.theta, start=place.at.start):
                    if i in where:
                        B[row, where[i]] += partial


@dataclass(frozen=True, slots=True)
class _Reads:
    """Which arguments a term reads at all."""

    x: bool
    a: bool
    s: bool


def _probe(term: Term) -> _Reads:
    point, zero = np.full(1, 0.3), np.zeros(1)
    m = Motion(point, point, zero, np.ones(1), point, np.full((len(term.states), 1), 0.3))
    p = [q.guess or min(1.0, q.bounds[1]) for q in term.parameters]
    partials = (term.partials(m, p), *term.rate_partials(m, p))
    return _Reads(*(any(not _absent(getattr(d, name)) for d in partials) for name in ("x", "a", "s")))


def _absent(partial: Array | float) -> bool:
    """Whether a partial is the structural zero of `Partials`."""
    return isinstance(partial, float) and partial == 0.0


def _sum(selection: Selection, rows: Array) -> Array:
    (j, c), *rest = selection
    total: Array = rows[j] if c == 1.0 else c * rows[j]
    for j, c in rest:
        total = total + c * rows[j]
    return total


def _times(gain: Array, columns: Array) -> Array:
    """gain (nv, nv, 1 or n) times columns (nv, n) or (nv, k, n)."""
    if gain.shape[0] == 1:
        return np.asarray(gain[0] * columns)
    if columns.ndim == 2:
        return np.asarray((gain * columns[None]).sum(axis=1))
    return np.asarray((gain[:, :, None] * columns[None]).sum(axis=1))


def _hold(mass: Array, locked: Mask) -> Array:
    """The mass matrix with rows and columns of locked coordinates those of the identity, (nv, nv, n)."""
    held = np.broadcast_to(mass, (*mass.shape[:2], locked.shape[1])).copy()
    for j in np.flatnonzero(locked.any(axis=1)):
        held[j][:, locked[j]] = 0.0
        held[:, j][:, locked[j]] = 0.0
        held[j, j, locked[j]] = 1.0
    return held
