"""A joint: terms at ports, summed by virtual work into equations of motion and their exact derivatives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.model.array import Array, Mask
from robotid.model.channel import Channel
from robotid.model.geometry import Selection
from robotid.model.layout import Layout
from robotid.model.linear_algebra import clear_sticking, inverse, product, stacked, with_sticking
from robotid.model.port import Port, Signal
from robotid.model.port_motion import Lever, Placed, PortMotion, Tangent, absent, bent, combine, own_tangent
from robotid.model.reads import Reads
from robotid.model.term import Motion, MotionTransform, Term


@dataclass(slots=True)
class Dynamics:
    """Right-hand side and derivatives at n points.

    f (nx, n); A = df/dx (nx, nx, n); B = df/d(theta[columns], u) (nx, k + 1, n), or None.
    """

    f: Array
    A: Array
    B: Array | None


class Joint(Layout):
    """Equations of motion of one joint, vectorised over samples. Arguments as of `Layout`."""

    def with_more(
        self,
        *,
        terms: Sequence[tuple[Port, Term]] = (),
        channels: Sequence[tuple[Signal, Channel]] = (),
        angle: bool = False,
    ) -> Joint:
        """The same joint with further effects behind its own."""
        angle = angle or self.keeps_angle
        return Joint(self.structure, [*self.terms, *terms], [*self.channels, *channels], angle=angle)

    def motions(self, x: Array, ddq: Array | None, s: Array, t: Array, theta: Array) -> list[Motion]:
        """What each term feels at states x (nx, n), accelerations ddq (nv, n) or None for rest, directions s."""
        felts = self._feel(x, s, t, theta)
        return [
            felt.m if ddq is None else felt.accelerated(_sum(place.q, ddq)).m
            for place, felt in zip(self.placed, felts, strict=True)
        ]

    def settled(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """States x (nx, n) with the terms' memory as long motion at these positions and speeds leaves it."""
        if self.nx > self.speeds.stop:
            x = x.copy()
            for place, m in zip(self.placed, self.motions(x, None, s, t, theta), strict=True):
                for row, value in enumerate(place.term.settled(m, place.values(theta)), start=place.z.start):
                    x[row] = value
        return x

    def force(self, x: Array, u: Array, s: Array, t: Array, theta: Array) -> Array:
        """Generalised force B u - sum S^T tau(x, v, 0), (nv, n)."""
        return self._force(self._feel(x, s, t, theta), u, theta)

    def slopes(self, x: Array, s: Array, t: Array, theta: Array) -> tuple[Array, Array]:
        """d(force)/dx (nv, nx, n) without accelerations, and the mass matrix (nv, nv, 1 or n)."""
        felts = self._feel(x, s, t, theta)
        jacobian = np.zeros((self.masses, self.nx, x.shape[1]))
        for place, felt in zip(self.placed, felts, strict=True):
            self._add_torque(place, felt, theta, jacobian, None, {})
        return jacobian, self._mass_matrix(felts, theta)

    def _feel(
        self, x: Array, s: Array, t: Array, theta: Array, places: Sequence[Placed] | None = None
    ) -> list[PortMotion]:
        """What each place feels: the motion of its port, bent by the bends there, and the torque it reads."""
        places = self.placed if places is None else places
        ports = {port: self._raw(place, x, s, t) for port, place in {p.port: p for p in places}.items()}
        felts: dict[int, PortMotion] = {}
        transforms = [(k, place.transform) for k, place in enumerate(places) if place.transform is not None]
        # Errors of the teeth come before play between them, whatever the order of the list.
        for k, transform in sorted(transforms, key=lambda one: one[1].watches is None):
            place = places[k]
            felts[k] = self._at(place, ports[place.port], x, s, theta)
            watched = self._watched(transform, x, s, t)
            ports[place.port] = bent(place, ports[place.port], felts[k].m, watched, place.values(theta), self.nx)
        for k, place in enumerate(places):
            if k not in felts:
                felts[k] = self._at(place, ports[place.port], x, s, theta)
        read = {k: self._read(place, places, felts, theta) for k, place in enumerate(places) if place.term.reads}
        return [
            replace(felts[k], m=replace(felts[k].m, tau=read[k][0]), tau=read[k][1]) if k in read else felts[k]
            for k in range(len(places))
        ]

    def _raw(self, place: Placed, x: Array, s: Array, t: Array) -> PortMotion:
        """The motion of a port itself."""
        v, zero = _sum(place.v, x), np.zeros(1)
        direction = s[place.q[0][0]] * np.sign(place.q[0][1]) if len(place.q) == 1 else np.sign(v)
        m = Motion(_sum(place.x, x) if place.x else zero, v, zero, direction, t, x[:0])
        return PortMotion(m, dict(place.x), dict(place.v), {}, {}, tuple(Lever(j, c) for j, c in place.q))

    def _at(self, place: Placed, felt: PortMotion, x: Array, s: Array, theta: Array) -> PortMotion:
        """The same motion with the term's own memory and sides; sides not given are those of the distances."""
        term = place.term
        if not term.states and not term.edges:
            return felt
        m = replace(felt.m, z=x[place.z])
        if term.edges:
            given = place.acts and len(s) > self.masses
            m = replace(m, side=s[place.side] if given else np.sign(stacked(term.distance(m, place.values(theta)), x)))
        return replace(felt, m=m)

    def directions(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Directions of motion s (nv, n) and, below them, the sides of all edges, (nv + edges, n)."""
        if not self.edges:
            return s
        felts = self._feel(x, s[: self.masses], t, theta)
        sides = [felt.m.side for place, felt in zip(self.placed, felts, strict=True) if place.term.edges]
        return np.concatenate([s[: self.masses], *sides])

    def distances(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Distances of all edges, (edges, n). Arguments as of `evaluate`."""
        felts = zip(self.placed, self._feel(x, s, t, theta), strict=True)
        found = [place.term.distance(felt.m, place.values(theta)) for place, felt in felts]
        return stacked([distance for own in found for distance in own], x)

    def distance_slopes(
        self, x: Array, s: Array, t: Array, theta: Array, columns: Sequence[int] | None = None
    ) -> tuple[Array, Array, Array | None]:
        """Distances of all edges, and their derivatives to x (edges, nx, n) and to theta[columns] and u,
        (edges, k + 1, n)."""
        slopes = np.zeros((self.edges, self.nx, x.shape[1]))
        response = None if columns is None else np.zeros((self.edges, len(columns) + 1, x.shape[1]))
        where = {} if columns is None else {self.nx + c: k for k, c in enumerate(columns)}
        for place, felt in zip(self.placed, self._feel(x, s, t, theta), strict=True):
            partials = place.term.distance_partials(felt.m, place.values(theta))
            for row, d in enumerate(partials, start=place.side.start - self.masses):
                tangent = felt.chain(d, own_tangent(place, d, self.nx))
                for in_state, k, value in _entries(tangent, self.nx, response, where):
                    matrix = slopes if in_state else response
                    if matrix is not None:
                        matrix[row, k] += value
        return self.distances(x, s, t, theta), slopes, response

    def _watched(self, transform: MotionTransform, x: Array, s: Array, t: Array) -> PortMotion | None:
        if transform.watches is None:
            return None
        port = self._place(transform.watches, transform, 0, 0, 0, Reads(x=True, a=False, s=False), acts=True)
        return self._raw(port, x, s, t)

    def _read(
        self, reader: Placed, places: Sequence[Placed], felts: dict[int, PortMotion], theta: Array
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
                p, felt = place.values(theta), felts[k]
                factor = dict(place.q).get(j, 0.0) / own
                total = total + factor * place.term.torque(felt.m, p)
                d = place.term.partials(felt.m, p)
                parts.append((factor, felt.chain(d, own_tangent(place, d, self.nx))))
        return total, combine(parts)

    def _force(self, felts: Sequence[PortMotion], u: Array, theta: Array) -> Array:
        force = np.zeros((self.masses, len(u)))
        force[0] = u
        for place, felt in zip(self.placed, felts, strict=False):
            tau = place.term.torque(felt.m, place.values(theta))
            for lever in felt.levers:
                force[lever.j] -= lever.c * tau
        return force

    def _mass_matrix(self, felts: Sequence[PortMotion], theta: Array) -> Array:
        """M = sum S^T (dtau/da) S, (nv, nv, n), or (nv, nv, 1) where it does not change."""
        mass = np.zeros((self.masses, self.masses, 1))
        for place, felt in zip(self.placed, felts, strict=False):
            if place.reads_acceleration:
                a = place.term.partials(felt.m, place.values(theta)).a
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
        sticking: Mask | None = None,
        columns: Sequence[int] | None = None,
    ) -> Dynamics:
        """Right-hand side and its derivatives.

        x : (nx, n); u : (n,) motor torque; s : (nv, n) directions of motion, with the sides of all edges below them
        (nv + edges, n) where these are not to be those of the distances; t : (n,); theta : (p,). sticking : (nv, n)
        coordinates that stick. columns : indices into theta of the derivatives wanted; -1 - j asks for that to a force
        on coordinate j.
        """
        n, nv = x.shape[1], self.masses
        felts = self._feel(x, s, t, theta)
        force, mass = self._force(felts, u, theta), self._mass_matrix(felts, theta)
        if sticking is not None:
            force, mass = np.where(sticking, 0.0, force), with_sticking(mass, sticking)
        gain = inverse(mass)
        ddq = product(gain, force)
        jacobian = np.zeros((nv, self.nx, n))
        response = None if columns is None else np.zeros((nv, len(columns) + 1, n))
        f, A = np.empty((self.nx, n)), np.zeros((self.nx, self.nx, n))
        B = None if columns is None else np.zeros((self.nx, len(columns) + 1, n))
        flow = len(self.positions)
        f[:flow], f[self.speeds] = self.positions @ x[self.speeds], ddq
        A[:flow, self.speeds] = self.positions[:, :, None]
        where = {} if columns is None else {self.nx + c: k for k, c in enumerate(columns)}
        for place, felt in zip(self.placed, felts, strict=True):
            moving = felt.accelerated(_sum(place.q, ddq)) if place.reads_acceleration else felt
            self._add_torque(place, moving, theta, jacobian, response, where)
            if place.term.states:
                self._add_memory(place, felt, theta, f, A, B, where)
        if response is not None and columns is not None:
            response[0, -1] = 1.0
            for k, c in enumerate(columns):
                if c < 0:
                    response[-1 - c, k] = 1.0
        if sticking is not None:
            clear_sticking(jacobian, sticking)
            if response is not None:
                clear_sticking(response, sticking)
        product(gain, jacobian, out=A[self.speeds])
        if response is not None and B is not None:
            product(gain, response, out=B[self.speeds])
        return Dynamics(f, A, B)

    def _add_torque(
        self,
        place: Placed,
        felt: PortMotion,
        theta: Array,
        jacobian: Array | None,
        response: Array | None,
        where: dict[int, int],
    ) -> None:
        """What a term's torque adds to the derivatives of the force; at the null of a candidate the rest vanishes."""
        if place.transform is not None:
            return
        p = place.values(theta)
        d = place.term.partials(felt.m, p)
        own = own_tangent(place, d, self.nx, parameters=response is not None)
        for target, k, value in _entries(felt.chain(d, own) if place.acts else own, self.nx, response, where):
            matrix = jacobian if target else response
            if matrix is not None:
                for lever in felt.levers:
                    if not absent(lever.c):
                        matrix[lever.j, k] -= lever.c * value
        turning = [lever for lever in felt.levers if lever.dc] if place.acts else []
        tau = place.term.torque(felt.m, p) if turning else 0.0
        for lever in turning:
            for target, k, value in _entries(lever.dc, self.nx, response, where):
                matrix = jacobian if target else response
                if matrix is not None:
                    matrix[lever.j, k] -= value * tau

    def _add_memory(
        self, place: Placed, felt: PortMotion, theta: Array, f: Array, A: Array, B: Array | None, where: dict[int, int]
    ) -> None:
        p = place.values(theta)
        rates, slopes = place.term.rate(felt.m, p), place.term.rate_partials(felt.m, p)
        for row, rate, d in zip(range(place.z.start, place.z.stop), rates, slopes, strict=True):
            f[row] = rate
            tangent = felt.chain(d, own_tangent(place, d, self.nx))
            for in_state, k, value in _entries(tangent, self.nx, B, where):
                matrix = A if in_state else B
                if matrix is not None:
                    matrix[row, k] += value


def _entries(
    tangent: Tangent, nx: int, response: Array | None, where: dict[int, int]
) -> Iterator[tuple[bool, int, Array | float]]:
    """Where the parts of a tangent go: (to the state or else to the wanted parameters, column, value)."""
    for key, value in tangent.items():
        if key < nx:
            yield True, key, value
        elif response is not None and key in where:
            yield False, where[key], value


def _sum(selection: Selection, rows: Array) -> Array:
    (j, c), *rest = selection
    total: Array = rows[j] if c == 1.0 else c * rows[j]
    for j, c in rest:
        total = total + c * rows[j]
    return total
