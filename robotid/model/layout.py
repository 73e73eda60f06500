"""How a joint is laid out: which rows of its state and which entries of theta belong to which effect.

Coordinates q are the angles (phi_m, phi_a, phi_b), as many as there are masses. The state is
x = (positions, speeds, memory): positions are the twists of gear and link, and phi_m where anything reads it;
speeds are dq; memory the states of the terms. Twists are states of their own because they are a thousand times smaller
than the angles they are the difference of.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from typing import Literal, Self

import numpy as np

from robotid.errors import ConfigError, InputError
from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.companion import MOTOR_ANGLE, Accompanied, Course
from robotid.model.geometry import coordinates, position, rigid_speed, rotates
from robotid.model.parameters import Parameter, Parameters
from robotid.model.port import Port, Signal
from robotid.model.port_motion import Placed, PortGeometry
from robotid.model.reads import Reads, reads_of
from robotid.model.signal_matrix import Rows, of_numbers
from robotid.model.structure import Structure, changed
from robotid.model.term import MotionTransform, Role, Term
from robotid.model.units import on_axis


class Layout:
    """States and parameters of one joint.

    terms : (port, term) pairs; channels : (signal, channel) pairs; ratio : phi_a / phi_m.
    angle : keep phi_m as a state even where no effect depends on it. turning : of each term, whether it depends on an
    absolute angle, and so on phi_m; follows_angle : whether, beside a record, these act at the recorded phi_m.
    ports : how each port moves. before_edges : the places whose motion tells the distances of all edges. positions
    (positions, nv) : d(position states)/dq, and flow : the same as derivatives of their rates to the states.
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
        self.companions: Mapping[str, Course] = {}
        ports = {port for port, _ in terms}
        self.masses = 1 if not ports & {Port.GEAR, Port.LINK, Port.TOOL} else 3 if Port.TOOL in ports else 2
        if structure.gear_ratio is None and ports != {Port.MOTOR}:
            raise ConfigError("effects beyond the motor need robot.gear_ratio", where="robot.model")
        self.ratio = structure.gear_ratio or 1.0
        probes = [reads_of(term) for _, term in terms]
        turning = rotates(self.masses)
        self.turning = tuple(
            (probe.x and port in turning) or getattr(term, "watches", None) in turning
            for (port, term), probe in zip(terms, probes, strict=True)
        )
        self.keeps_angle = angle or any(signal is Signal.ANGLE for signal, _ in channels) or any(self.turning)
        self.follows_angle = structure.recorded_angle and any(self.turning)
        self._lay_out(terms, probes)
        names = [(f"{port}.{term.name}", term.parameters) for port, term in terms]
        names += [(f"{signal}.{channel.name}", channel.parameters) for signal, channel in self.channels]
        self.declared: tuple[Parameter, ...] = tuple(p for _, ps in names for p in ps)
        self.names: tuple[str, ...] = tuple(f"{name}.{p.symbol}" for name, ps in names for p in ps)
        self._lay_out_changes()

    @property
    def terms(self) -> list[tuple[Port, Term]]:
        """Its (port, term) pairs."""
        return [(place.port, place.term) for place in self.placed]

    def at_mean_companions(self) -> Self:
        """The joint while its companions rest at their means: itself where there are none."""
        if not self.companions:
            return self
        joint = copy(self)
        joint.companions = {name: course.resting for name, course in self.companions.items()}
        return joint

    @property
    def reads_companions(self) -> bool:
        """Whether an effect depends on a further recorded signal."""
        return any(effect.companion_name for effect in self._effects)

    @property
    def courses_read(self) -> frozenset[str]:
        """Names of the signals of a recording on which its equations depend, of those that `along` lays beside it."""
        read = {effect.companion_name for effect in self._effects if effect.companion_name}
        return frozenset(read | {MOTOR_ANGLE} if self.follows_angle else read)

    @property
    def depends_on_record(self) -> bool:
        """Whether its equations are not the same beside every record."""
        return bool(self.changes) or self.reads_companions or self.follows_angle

    @property
    def _effects(self) -> list[Term | Channel]:
        return [*(place.term for place in self.placed), *(channel for _, channel in self.channels)]

    def along(self, recording: Accompanied) -> Self:
        """The joint beside the companions of a recording, and its motor's angle where a torque acts at that.

        Raises InputError where the recording lacks one that an effect reads.
        """
        courses = dict(recording.courses)
        for effect in self._effects:
            if effect.companion_name and effect.companion_name not in courses:
                what = f"{effect.name} reads {effect.companion_name}, which was not recorded"
                hint = f"add it under signals of the record, or leave out {effect.name}"
                raise InputError(what, where=recording.name, hint=hint)
        if self.follows_angle:
            courses[MOTOR_ANGLE] = recording.motor_course
        if not courses:
            return self
        joint = copy(self)
        joint.companions = courses
        joint.channels = tuple((signal, channel.beside(courses)) for signal, channel in self.channels)
        return joint

    @property
    def motor_speed(self) -> int:
        """Row of the motor's speed in the state."""
        return self.speeds.start

    @property
    def motor_angle(self) -> int:
        """Row of the motor's angle in the state. Raises ValueError where the joint does not keep it."""
        if not self.keeps_angle:
            raise ValueError("this joint does not keep its angle as a state")
        return self.speeds.start - 1

    @property
    def motor_states(self) -> slice:
        """Rows of the motor's own states: its angle, where the joint keeps it, and its speed."""
        return slice(self.speeds.start - self.keeps_angle, self.speeds.start + 1)

    def output_row(self, quantity: Literal["speed", "position"]) -> int:
        """Row of the state that is this measured quantity of the motor."""
        return self.motor_angle if quantity == "position" else self.motor_speed

    def playing(self, role: Role) -> dict[str, Placed]:
        """Its masses, springs or dampers, linear or not, by the dotted name of their inertia, stiffness or damping."""
        return {self.names[place.at.start]: place for place in self.placed if place.term.role is role}

    def rigid_speed(self, port: Port) -> float:
        """Speed of a port in motor speeds while all masses move together."""
        return rigid_speed(port, self.masses, self.ratio)

    def _lay_out(self, terms: Sequence[tuple[Port, Term]], probes: Sequence[Reads]) -> None:
        nv, npos = self.masses, self.masses - 1 + self.keeps_angle
        r = self.ratio
        motion = np.array([[r, -1.0, 0.0], [0.0, 1.0, -1.0]])[: nv - 1, :nv]
        self.positions: Array = np.vstack([motion, np.eye(1, nv)]) if self.keeps_angle else motion
        self.speeds = slice(npos, npos + nv)
        self.flow: Rows = [{npos + j: c for j, c in row.items()} for row in of_numbers(self.positions)]
        self.ports = {port: self._port(port) for port in Port}
        placed, theta, memory, sides = [], 0, npos + nv, nv
        dry = np.zeros(nv, dtype=bool)
        for (port, term), probe in zip(terms, probes, strict=True):
            place = self._place(port, term, theta, memory, sides, probe, acts=True)
            placed.append(place)
            theta, memory, sides = place.at.stop, place.z.stop, place.side.stop
            if probe.s and len(place.q) == 1:
                dry[place.q[0][0]] = True
        self.placed = tuple(placed)
        self.dry = tuple(int(j) for j in np.flatnonzero(dry))
        self.nx, self.n_theta, self.edges = memory, theta, sides - nv
        edged = {place.port for place in placed if place.term.edges}
        self.before_edges = tuple(p for p in placed if p.term.edges or (p.transform is not None and p.port in edged))

    def _lay_out_changes(self) -> None:
        """Parameters that differ in one record: the difference follows all other parameters."""
        self.changes: tuple[tuple[str, int], ...] = ()
        own = self.names
        for effect in self.structure.changes:
            record, name = changed(effect)
            if name not in own:
                raise ConfigError(f'the model has no parameter "{name}" to change', where="robot.changes")
            k = own.index(name)
            meaning = f"difference of {name} in {record}"
            self.declared += (Parameter(self.declared[k].symbol, self.declared[k].unit, meaning, 0.0, null=0.0),)
            self.names += (effect,)
            self.changes += ((record, k),)

    def channels_on(self, theta: Array, *signals: Signal) -> Iterator[tuple[Signal, Channel, list[float], int]]:
        """Channels on these signals, in order: (signal, channel, its parameters, index of their first in theta)."""
        first = self.n_theta
        for signal, channel in self.channels:
            last = first + len(channel.parameters)
            if signal in signals:
                yield signal, channel, theta[first:last].tolist(), first
            first = last

    def in_record(self, theta: Array, record: str) -> Array:
        """All parameters as they are in one record, (p,): its differences added, none left."""
        if not self.changes:
            return theta
        theta, first = theta.copy(), len(theta) - len(self.changes)
        for i, (where, k) in enumerate(self.changes, start=first):
            theta[k] += theta[i] if where == record else 0.0
        theta[first:] = 0.0
        return theta

    def is_one_in(self, records: Iterable[str]) -> bool:
        """Whether its parameters are the same in all these records, by name."""
        return not self.changes or len(set(records)) == 1

    def sources(self, columns: Sequence[int], record: str) -> list[int | None]:
        """The parameter that each column moves in a record: itself, what a difference adds to, or None."""
        first = len(self.names) - len(self.changes)
        moved = {first + i: k if where == record else None for i, (where, k) in enumerate(self.changes)}
        return [moved.get(c, c) for c in columns]

    def _place(
        self, port: Port, term: Term, theta: int, memory: int, sides: int, probe: Reads, *, acts: bool
    ) -> Placed:
        where = self.ports[port]
        at, z = slice(theta, theta + len(term.parameters)), slice(memory, memory + len(term.states))
        side = slice(sides, sides + len(term.edges))
        transform = term if isinstance(term, MotionTransform) else None
        positioned = probe.x or transform is not None or bool(term.edges)
        return Placed(port, term, at, where.x, where.v, where.q, z, side, positioned, probe.a, transform, acts)

    def _port(self, port: Port) -> PortGeometry:
        nv, r = self.masses, self.ratio
        q = coordinates(port, nv, r)
        v = tuple((self.speeds.start + j, c) for j, c in q)
        x = position(port, nv, r) if self.keeps_angle or port not in rotates(nv) else ()
        return PortGeometry(x, v, q, self.motor_angle if self.keeps_angle else None)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        positions = ("twist", "link_twist")[: self.masses - 1] + (("phi_m",) if self.keeps_angle else ())
        memory = tuple(f"{p.port}.{p.term.name}.{s}" for p in self.placed for s in p.term.states)
        return (*positions, *("dphi_m", "dphi_a", "dphi_b")[: self.masses], *memory)

    @property
    def state_limits(self) -> dict[int, float]:
        """What the size of a state cannot exceed, by row of x, where that is known."""
        limited = [place for place in self.placed if np.isfinite(place.term.state_limit)]
        return {row: place.term.state_limit for place in limited for row in range(place.z.start, place.z.stop)}

    def parameters(self) -> Parameters:
        """Declared guesses and bounds, terms first and then channels; free are those that are ever estimated."""
        lower, upper = np.array([p.bounds for p in self.declared], dtype=np.float64).reshape(-1, 2).T
        values = np.array([p.guess for p in self.declared], dtype=np.float64)
        units = tuple(map(on_axis(linear=self.structure.linear), (p.unit for p in self.declared)))
        free = np.array([p.estimated for p in self.declared], dtype=bool)
        return Parameters(self.names, units, values, lower, upper, free)
