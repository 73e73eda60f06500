"""A joint: terms at ports, summed by virtual work into equations of motion and their exact derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.model import signal_matrix
from robotid.model.array import Array, Mask
from robotid.model.channel import Channel
from robotid.model.companion import MOTOR_ANGLE, CompanionsAt
from robotid.model.derivatives import (
    DerivativeColumns,
    Derivatives,
    Parts,
    SparseDerivatives,
    Tangent,
    absent,
    combine,
)
from robotid.model.geometry import Selection
from robotid.model.layout import Layout
from robotid.model.linear_algebra import inverse, stacked, with_sticking
from robotid.model.linear_part import LinearPart, linear_part
from robotid.model.port import Port, Signal
from robotid.model.port_motion import NOTHING, Placed, PortMotion, transformed
from robotid.model.signal_matrix import Rows
from robotid.model.term import Motion, Term


@dataclass(slots=True)
class Dynamics:
    """Right-hand side and derivatives at n points.

    f (nx, n); to_states (nx, nx) : df/dx, entry by entry; to_columns (nx, width) : df to the wanted parameters and
    forces and to the motor torque, or None.
    """

    f: Array
    to_states: Rows
    to_columns: Rows | None
    width: int

    @property
    def A(self) -> Array:
        """df/dx, (nx, nx, n)."""
        return signal_matrix.put(self.to_states, np.empty((len(self.f), *self.f.shape)))

    @property
    def B(self) -> Array | None:
        """The further derivatives, (nx, width, n)."""
        if self.to_columns is None:
            return None
        return signal_matrix.put(self.to_columns, np.empty((len(self.f), self.width, self.f.shape[1])))


@dataclass(slots=True)
class EdgeDistances:
    """Distances of all edges at n points and their derivatives.

    value (edges, n); to_states (edges, nx, n); to_columns (edges, width, n), or None.
    """

    value: Array
    to_states: Array
    to_columns: Array | None


class Joint(Layout):
    """Equations of motion of one joint, vectorised over samples. Arguments as of `Layout`.

    Arguments of its methods: x (nx, n) states; s (nv, n) directions of motion, with the sides of all edges below them
    (nv + edges, n) where these are not to be those of the distances; t (n,) time in the record; theta (p,) parameters
    in the order of `names`; u (n,) motor torque.
    """

    def with_more(
        self,
        *,
        terms: Sequence[tuple[Port, Term]] = (),
        channels: Sequence[tuple[Signal, Channel]] = (),
        angle: bool = False,
    ) -> Joint:
        """The same joint with further effects behind its own."""
        angle = angle or self.keeps_angle
        joint = Joint(self.structure, [*self.terms, *terms], [*self.channels, *channels], angle=angle)
        joint.companions = self.companions
        return joint

    def linear_at(self, theta: Array) -> LinearPart:
        """What of the equations is the same at every sample. Raises NumericsError where the joint has no mass."""
        return linear_part(self, theta)

    def motions(self, x: Array, ddq: Array | None, s: Array, t: Array, theta: Array) -> list[Motion]:
        """The motion that each term acts on, at accelerations ddq (nv, n), or None for rest."""
        motions = self._port_motions(x, s, t, theta)
        return [
            motion.m if ddq is None else motion.accelerated(_sum(place.q, ddq)).m
            for place, motion in zip(self.placed, motions, strict=True)
        ]

    def settled(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """States x (nx, n) with the terms' memory as long motion at these positions and speeds leaves it."""
        if self.nx > self.speeds.stop:
            x = x.copy()
            for place, m in zip(self.placed, self.motions(x, None, s, t, theta), strict=True):
                for row, value in enumerate(place.term.settled(m, place.values(theta)), start=place.z.start):
                    x[row] = value
        return x

    def force(self, x: Array, u: Array, s: Array, t: Array, theta: Array, linear: LinearPart | None = None) -> Array:
        """Generalised force B u - sum S^T tau(x, v, 0), (nv, n). linear : as of `evaluate`."""
        force: list[Array | float] = [u, *[0.0] * (self.masses - 1)] if linear is None else linear.force(x, u)
        places = self.placed if linear is None else linear.others
        motions = self._port_motions(x, s, t, theta, places, parameters=False, needed=True)
        _subtract_torques(force, zip(places, motions, strict=True), theta)
        return stacked(force, x)

    def slopes(self, x: Array, s: Array, t: Array, theta: Array) -> tuple[Array, Array]:
        """d(force)/dx (nv, nx, n) without accelerations, and the mass matrix (nv, nv, 1 or n)."""
        motions = self._port_motions(x, s, t, theta, needed=True)
        jacobian = np.zeros((self.masses, self.nx, x.shape[1]))
        for place, motion in zip(self.placed, motions, strict=True):
            self._add_torque(place, motion, theta, Derivatives(jacobian, None, {}))
        return jacobian, self._mass_matrix(zip(self.placed, motions, strict=True), theta)

    def directions(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Directions of motion s (nv, n) and, below them, the sides of all edges, (nv + edges, n)."""
        if not self.edges:
            return s
        motions = self._port_motions(x, s[: self.masses], t, theta, self.before_edges, parameters=False)
        sides = [motion.m.side for place, motion in zip(self.before_edges, motions, strict=True) if place.term.edges]
        return np.concatenate([s[: self.masses], *sides])

    def distances(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Distances of all edges, (edges, n)."""
        motions = self._port_motions(x, s, t, theta, self.before_edges, parameters=False)
        return self._distances(motions, x, theta)

    def distance_slopes(
        self, x: Array, s: Array, t: Array, theta: Array, columns: DerivativeColumns | None = None
    ) -> EdgeDistances:
        """Distances of all edges with their derivatives to the states and to what is wanted besides."""
        motions = self._port_motions(x, s, t, theta, self.before_edges, parameters=columns is not None)
        found = Derivatives.zeros(self.edges, self.nx, x.shape[1], columns)
        for place, motion in zip(self.before_edges, motions, strict=True):
            partials = place.term.distance_partials(motion.m, place.values(theta))
            for row, d in enumerate(partials, start=place.side.start - self.masses):
                found.add(row, motion.chain(d, place.tangent(d)))
        assert found.states is not None
        return EdgeDistances(self._distances(motions, x, theta), found.states, found.columns)

    def evaluate(
        self,
        x: Array,
        u: Array,
        s: Array,
        t: Array,
        theta: Array,
        sticking: Mask | None = None,
        columns: DerivativeColumns | None = None,
        linear: LinearPart | None = None,
    ) -> Dynamics:
        """Right-hand side and its derivatives.

        sticking : (nv, n) coordinates that friction keeps at rest. columns : what derivatives are wanted to beside the
        states; None for the states alone. linear : `linear_part` at these parameters, where it is known already.
        """
        linear = linear_part(self, theta) if linear is None else linear
        places, folded = (linear.others, None) if columns is None else (self.placed, linear.folded)
        motions = self._port_motions(x, s, t, theta, places, parameters=columns is not None, needed=True)
        evaluated = list(zip(places, motions, folded or (False,) * len(places), strict=True))
        sampled = [(place, motion) for place, motion, known in evaluated if not known]
        force, free = linear.force(x, u), _free(sticking, self.masses)
        _subtract_torques(force, sampled, theta)
        gain = self._gain(linear, sampled, theta, sticking)
        f, flow = np.empty((self.nx, x.shape[1])), len(self.positions)
        np.einsum("ij,jn->in", self.positions, x[self.speeds], out=f[:flow])
        moved = [one if isinstance(kept, float) else kept * one for one, kept in zip(force, free, strict=True)]
        ddq = f[self.speeds]
        for j, row in enumerate(gain):
            ddq[j] = sum(factor * moved[i] for i, factor in row.items())
        forces, rates = (SparseDerivatives.zeros(rows, columns) for rows in (self.masses, self.nx))
        forces.states[:] = [dict(row) for row in linear.slopes]
        for place, motion, known in evaluated:
            moving = motion.accelerated(_sum(place.q, ddq)) if place.reads_acceleration else motion
            self._add_torque(place, moving, theta, forces, only_parameters=known)
            if place.term.states:
                self._add_memory(place, motion, theta, f, rates)
        rates.states[:flow] = self.flow
        rates.states[self.speeds] = signal_matrix.multiply(gain, _kept(forces.states, free))
        if columns is None or forces.columns is None or rates.columns is None:
            return Dynamics(f, rates.states, None, 0)
        forces.columns[0][columns.width - 1] = 1.0
        for k, j in enumerate(columns.forces, start=len(columns.parameters)):
            forces.columns[j][k] = 1.0
        rates.columns[self.speeds] = signal_matrix.multiply(gain, _kept(forces.columns, free))
        return Dynamics(f, rates.states, rates.columns, columns.width)

    def _gain(
        self, linear: LinearPart, sampled: Sequence[tuple[Placed, PortMotion]], theta: Array, sticking: Mask | None
    ) -> Rows:
        """The inverse of the mass matrix, sticking coordinates cut off; of a diagonal one these need no cutting. Raises
        NumericsError where a mass that changes is not positive: such a motion explodes."""
        if linear.gain is not None and (sticking is None or linear.diagonal):
            return linear.gain
        changing = [one for one in sampled if one[0].reads_acceleration]
        mass = linear.mass[:, :, None] + self._mass_matrix(changing, theta)
        if any(mass[j, j].real.min() <= 0.0 for j in range(self.masses)):
            raise NumericsError("a mass is not positive in every pose", hint="check the parameters' guesses and bounds")
        if linear.diagonal and all(len(place.q) == 1 for place, _ in changing):
            return [{j: 1.0 / mass[j, j]} for j in range(self.masses)]
        if sticking is not None:
            mass = with_sticking(mass, sticking)
        return signal_matrix.of_signals(inverse(mass))

    def _port_motions(
        self,
        x: Array,
        s: Array,
        t: Array,
        theta: Array,
        places: Sequence[Placed] | None = None,
        *,
        parameters: bool = True,
        needed: bool = False,
    ) -> list[PortMotion]:
        """The motion that the term at each place acts on: its port's, behind the transforms there, with the torque that
        it reads. parameters : whether derivatives to those of the transforms are wanted; needed : whether a position is
        left out that no term at its port reads."""
        places = self.placed if places is None else places
        beside = CompanionsAt(self.companions, t)
        ports = {place.port: not needed for place in places}
        for place in places:
            ports[place.port] |= place.reads_position
        raw = {port: self._raw(port, x, s, beside, positioned=positioned) for port, positioned in ports.items()}
        motions: dict[int, PortMotion] = {}
        transforms = [(k, place.transform) for k, place in enumerate(places) if place.transform is not None]
        left = [place.port for place in places]
        # Errors of the teeth come before play between them, whatever the order of the list.
        for k, transform in sorted(transforms, key=lambda one: one[1].watches is None):
            place = places[k]
            before = raw[place.port]
            motions[k] = self._with_memory(place, before, x, s, theta, beside)
            left.remove(place.port)
            if place.port in left:
                watched = None if transform.watches is None else self._raw(transform.watches, x, s, beside)
                p = place.values(theta)
                raw[place.port] = transformed(place, before, motions[k].m, watched, p, parameters=parameters)
        for k, place in enumerate(places):
            if k not in motions:
                motions[k] = self._with_memory(place, raw[place.port], x, s, theta, beside)
        read = {k: self._read(place, places, motions, theta) for k, place in enumerate(places) if place.term.reads}
        for k, (tau, to_tau) in read.items():
            motions[k] = replace(motions[k], m=replace(motions[k].m, tau=tau), tau=to_tau)
        return [motions[k] for k in range(len(places))]

    def _raw(self, port: Port, x: Array, s: Array, beside: CompanionsAt, *, positioned: bool = True) -> PortMotion:
        """The motion of a port itself; the motor's angle in it is the recorded one where the joint follows that.
        positioned : whether its position is wanted."""
        place = self.ports[port]
        v = _sum(place.v, x)
        (j, c), *more = place.q
        direction = np.sign(v) if more else s[j] if c > 0.0 else -s[j]
        own, to_x = place.x, place.to_x
        followed = place.turn != 0.0 and MOTOR_ANGLE in self.companions
        if followed:
            own, to_x = place.free_x, place.to_free_x
        position = _sum(own, x) if own and positioned else STILL
        if followed and positioned:
            position = position + place.turn * beside.motor_angle
        return PortMotion(
            Motion(position, v, STILL, direction, beside.time, x[:0]), to_x, place.to_v, NOTHING, NOTHING, place.levers
        )

    def _with_memory(
        self, place: Placed, motion: PortMotion, x: Array, s: Array, theta: Array, beside: CompanionsAt
    ) -> PortMotion:
        """The same motion with the term's own memory and sides; sides not given are those of the distances."""
        term, m = place.term, motion.m
        if term.companion_name in self.companions:
            m = m.beside(beside(term.companion_name))
        elif not term.states and not term.edges:
            return motion
        if term.states or term.edges:
            m = m.remembering(x[place.z], m.side)
        if term.edges:
            given = place.acts and len(s) > self.masses
            side = s[place.side] if given else np.sign(stacked(term.distance(m, place.values(theta)), x))
            m = m.remembering(m.z, side)
        return PortMotion(m, motion.x, motion.v, motion.s, motion.tau, motion.levers)

    def _read(
        self, reader: Placed, places: Sequence[Placed], motions: dict[int, PortMotion], theta: Array
    ) -> tuple[Array | float, Tangent]:
        """The torque that a term reads, as it acts on the reader's coordinate, with its tangent."""
        reading = reader.term.reads
        assert reading is not None
        j, own = reader.q[0]
        total: Array | float = 0.0
        parts: list[tuple[Array | float, Tangent]] = []
        for k, place in enumerate(places):
            plain = place.acts and place.term.reads is None and not place.reads_acceleration
            meant = place.term.friction or not reading.friction
            if plain and meant and place.port is (reading.port or reader.port):
                p, motion = place.values(theta), motions[k]
                factor = dict(place.q).get(j, 0.0) / own
                total = total + factor * place.term.torque(motion.m, p)
                d = place.term.partials(motion.m, p)
                parts.append((factor, motion.chain(d, place.tangent(d))))
        return total, combine(parts)

    def _mass_matrix(self, sampled: Iterable[tuple[Placed, PortMotion]], theta: Array) -> Array:
        """M = sum S^T (dtau/da) S of these places, (nv, nv, n), or (nv, nv, 1) where it does not change."""
        mass = np.zeros((self.masses, self.masses, 1))
        for place, motion in sampled:
            if place.reads_acceleration:
                a = place.term.partials(motion.m, place.values(theta)).a
                added = np.zeros((self.masses, self.masses, np.size(a)))
                for i, ci in place.q:
                    for j, cj in place.q:
                        added[i, j] = ci * cj * a
                mass = mass + added
        return mass

    def _distances(self, motions: Sequence[PortMotion], x: Array, theta: Array) -> Array:
        pairs = zip(self.before_edges, motions, strict=True)
        found = [place.term.distance(motion.m, place.values(theta)) for place, motion in pairs]
        return stacked([distance for own in found for distance in own], x)

    def _add_torque(
        self,
        place: Placed,
        motion: PortMotion,
        theta: Array,
        forces: Derivatives | SparseDerivatives,
        *,
        only_parameters: bool = False,
    ) -> None:
        """What a term's torque adds to the derivatives of the force; at the null of a candidate the rest vanishes.
        only_parameters : those to states are known already."""
        if place.transform is not None:
            return
        p = place.values(theta)
        d = place.term.partials(motion.m, p)
        own = place.tangent(d, parameters=forces.columns is not None)
        tangent = motion.chain(d, own) if place.acts and not only_parameters else own
        for lever in motion.levers:
            if not absent(lever.c):
                forces.add(lever.j, tangent, -lever.c)
        turning = [(lever.j, lever.dc) for lever in motion.levers if lever.dc is not None] if place.acts else []
        tau = place.term.torque(motion.m, p) if turning else 0.0
        for j, turns in turning:
            forces.add(j, turns, -tau)

    def _add_memory(self, place: Placed, motion: PortMotion, theta: Array, f: Array, rates: SparseDerivatives) -> None:
        """The rates of a term's own states, and their derivatives."""
        p = place.values(theta)
        partials = place.term.rate_partials(motion.m, p)
        rows = range(place.z.start, place.z.stop)
        for row, rate, d in zip(rows, place.term.rate(motion.m, p), partials, strict=True):
            f[row] = rate
            rates.add(row, motion.chain(d, place.tangent(d)))


STILL = np.zeros(1)
STILL.flags.writeable = False


def _sum(selection: Selection, rows: Array) -> Array:
    (j, c), *rest = selection
    total: Array = rows[j] if c == 1.0 else c * rows[j]
    for j, c in rest:
        total = total + c * rows[j]
    return total


def _subtract_torques(force: list[Array | float], sampled: Iterable[tuple[Placed, PortMotion]], theta: Array) -> None:
    """Take the torques at these places from the generalised force, in place."""
    for place, motion in sampled:
        tau = place.term.torque(motion.m, place.values(theta))
        for lever in motion.levers:
            force[lever.j] = force[lever.j] - lever.c * tau


def _free(sticking: Mask | None, masses: int) -> list[Array | float]:
    """One where a coordinate moves, zero where it sticks."""
    if sticking is None:
        return [1.0] * masses
    return [1.0 - still if still.any() else 1.0 for still in sticking]


def _kept(rows: Sequence[Parts], free: Sequence[Array | float]) -> Rows:
    """Derivatives of the forces, none on coordinates that stick."""
    pairs = zip(rows, free, strict=True)
    return [row if isinstance(kept, float) else signal_matrix.scale(kept, [row])[0] for row, kept in pairs]
