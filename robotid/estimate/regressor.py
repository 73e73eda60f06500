"""The regressor of a rigid joint, eq. (10): what each parameter adds to the motor torque as all masses move together.

Columns are the terms' own derivatives to their parameters, so every effect of the catalogue is known here at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from robotid.model import term
from robotid.model.array import Array, Mask
from robotid.model.companion import Course
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.port import GROUNDED, Port
from robotid.model.port_motion import Placed
from robotid.signals.differentiate import Kinematics, ParallelFilter
from robotid.signals.record import Record
from robotid.simulation.internal_states import simulate_internal_states

MAX_KEPT = 1_000_000  # samples of a record whose motion is kept from one regression to the next
MAX_KEPT_COLUMNS = 4_000_000  # samples of all columns of a record that are kept: each grid point of an effect has some
MAX_DEVIATION = 1e-6  # distance, in parts of its length, at which one column is the multiple of another

Transforming = tuple[term.MotionTransform, list[float]]
"""A transform of a port's motion, and the values of its parameters."""


@dataclass(frozen=True, slots=True, eq=False)
class Regression:
    """One record as tau = columns^T theta, filtered and decimated.

    names (p,); columns (p, n); motor_side (p, n), the columns if their effects sat on the motor; torque (n,) as
    recorded; tau (n,) less the part of parameters that are fixed.
    """

    names: tuple[str, ...]
    columns: Array
    motor_side: Array
    torque: Array
    tau: Array


@dataclass(frozen=True, slots=True)
class Merged:
    """An unknown of the rigid joint: a parameter, or a sum of parameters that only act together.

    members, ratios : name = sum of ratio * member.
    """

    name: str
    members: tuple[str, ...]
    ratios: tuple[float, ...]


@dataclass(slots=True, eq=False)
class FilteredRecord:
    """A record through a parallel filter. What regressions of several models on it have in common is worked out once:
    the motion, of records that are short enough to keep it, and filtered columns, by effect, values of its parameters
    and parameter, as many as there is room for.

    left_out : samples (n,) that tell nothing, None where all do.
    """

    record: Record
    parallel: ParallelFilter
    left_out: Mask | None = None
    columns: dict[tuple[str, tuple[float, ...], int, bool], Array] = field(default_factory=dict)
    torques: tuple[Array, Array, Array, Array] | None = None
    known_motion: Kinematics | None = None

    @property
    def motion(self) -> Kinematics:
        """The recorded motion, as the filter takes it."""
        if self.known_motion is not None:
            return self.known_motion
        found = self.parallel.motion(self.record.phi_m, self.record.sampling_time)
        if len(self.record) <= MAX_KEPT:
            self.known_motion = found
        return found

    def apply(self, signal: Array) -> Array:
        """A signal (n,) through the filter."""
        return self.parallel.apply(signal, self.record.sampling_time)

    def telling(self, speed: Array) -> Mask:
        """Which samples are fast enough and show nothing of those that are left out. speed (m,) : filtered."""
        kept = np.abs(speed) >= self.parallel.min_speed
        if self.left_out is None:
            return kept
        return kept & ~self.parallel.reached_by(self.left_out, self.record.sampling_time)

    def torque_less(self, known: Array, speed: Array) -> tuple[Array, Array, Array]:
        """The recorded torque, what is left of it less what is known (n,), and the speed (n,), filtered."""
        if self.torques is not None and np.array_equal(self.torques[0], known):
            return self.torques[1:]
        applied = self.parallel.applied(self.record.tau_m, self.record.sampling_time)
        torque, tau, filtered = (self.apply(signal) for signal in (applied, applied - known, speed))
        if len(self.record) <= MAX_KEPT:
            self.torques = known, torque, tau, filtered
        return torque, tau, filtered


def regress(joint: Joint, parameters: Parameters, record: Record, parallel: ParallelFilter) -> Regression:
    """The linear regression of one record. Fixed and shape parameters keep their values."""
    return regress_on(FilteredRecord(record, parallel), joint, parameters)


def regress_on(filtered: FilteredRecord, joint: Joint, parameters: Parameters) -> Regression:
    """The same of a record on which several models are regressed."""
    record, motion = filtered.record, filtered.motion
    names: list[str] = []
    own: list[Array] = []
    motor_side: list[Array] = []
    known = np.zeros(len(record))
    courses, t = record.courses, record.t
    transforms = _transforms(joint, parameters)
    for place, factor in moving(joint):
        p = list(parameters.values[place.at])
        course, transform = courses.get(place.term.companion_name), transforms.get(place.port)
        moving_port = _at(motion, t, factor, course, transform)
        known += factor * place.term.torque(moving_port, p)
        here = _columns(place, moving_port, factor, p)
        there = here if factor == 1.0 else _columns(place, _at(motion, t, 1.0, course), 1.0, p)
        shape = (*p, *(() if transform is None else transform[1]))
        del moving_port  # of a long record, as large as the record
        for k, declared in enumerate(place.term.parameters, start=place.at.start):
            if parameters.free[k] and not declared.is_shape:
                names.append(joint.names[k])
                column, other = (columns[k - place.at.start] for columns in (here, there))
                own.append(_filtered(filtered, column, (place.effect, shape, k - place.at.start, False)))
                alike = other is column
                key = (place.effect, shape, k - place.at.start, True)
                motor_side.append(own[-1] if alike else _filtered(filtered, other, key))
                known -= parameters.values[k] * column
    torque, tau, speed = filtered.torque_less(known, motion.speed)
    kept = filtered.telling(speed)
    columns = np.array([*own, *motor_side]).reshape(2, len(names), len(tau))[:, :, kept]
    return Regression(tuple(names), columns[0], columns[1], torque[kept], tau[kept])


def _filtered(filtered: FilteredRecord, column: Array, key: tuple[str, tuple[float, ...], int, bool]) -> Array:
    """A column through the filter, at once, so that no unfiltered column is kept."""
    found = filtered.columns.get(key)
    if found is None:
        found = filtered.apply(column)
        if (len(filtered.columns) + 1) * len(column) <= MAX_KEPT_COLUMNS:  # those of the first model come first
            filtered.columns[key] = found
    return found


def friction_power(joint: Joint, parameters: Parameters, record: Record, parallel: ParallelFilter) -> float:
    """Mean power [W] that all friction of a rigid motion absorbs, negative where it drives the joint."""
    motion = parallel.motion(record.phi_m, record.sampling_time)
    power, t, transforms = np.zeros(len(record)), record.t, _transforms(joint, parameters)
    for place, factor in moving(joint):
        if place.term.friction:
            course = record.courses.get(place.term.companion_name)
            at = _at(motion, t, factor, course, transforms.get(place.port))
            power += at.v * place.term.torque(at, list(parameters.values[place.at]))
    return float(np.mean(power))


def moving(joint: Joint) -> Iterator[tuple[Placed, float]]:
    """Terms that move when the joint moves rigidly and depend on that motion alone (neither on memory nor on other
    terms), with the speed of their port in motor speeds."""
    for place in joint.placed:
        own = not place.term.states and place.term.reads is None and not isinstance(place.term, term.MotionTransform)
        if place.port in GROUNDED and own:
            yield place, joint.rigid_speed(place.port)


def _transforms(joint: Joint, parameters: Parameters) -> dict[Port, Transforming]:
    """What changes the motion that the other terms at a port act on, as far as that depends on the port's own motion
    alone, with its values."""
    found = dict[Port, Transforming]()
    for place in joint.placed:
        if place.port in GROUNDED and place.transform is not None and place.transform.watches is None:
            found[place.port] = place.transform, place.values(parameters.values)
    return found


def merge(regressions: list[Regression]) -> tuple[Merged, ...]:
    """Which columns are one unknown: equal effect and symbol at several ports, columns multiples of each other."""
    names = regressions[0].names
    own, motor_side = (np.hstack([getattr(r, key) for r in regressions]) for key in ("columns", "motor_side"))
    groups: dict[str, list[tuple[str, float]]] = {}
    for k, name in enumerate(names):
        _, effect, symbol = name.split(".")
        twins = [other for other in names if other.split(".")[1:] == [effect, symbol]]
        ratio = _multiple(own[k], motor_side[names.index(twins[0])])
        shared = len(twins) > 1 and ratio is not None
        groups.setdefault(f"joint.{effect}.{symbol}" if shared else name, []).append(
            (name, ratio if shared and ratio else 1.0)
        )
    return tuple(Merged(name, *zip(*members, strict=True)) for name, members in groups.items())


def _multiple(column: Array, base: Array) -> float | None:
    """The factor that makes base the column, None where none does."""
    square = float(base @ base)
    if square == 0.0:
        return None
    ratio = float(base @ column) / square
    return ratio if np.linalg.norm(column - ratio * base) <= MAX_DEVIATION * np.linalg.norm(column) and ratio else None


def _columns(place: Placed, m: term.Motion, factor: float, p: list[float]) -> list[Array]:
    partials = place.term.partials(m, p).theta
    return [np.broadcast_to(factor * np.asarray(d, dtype=np.float64), m.t.shape) for d in partials]


def _at(
    motion: Kinematics, t: Array, factor: float, course: Course | None, transform: Transforming | None = None
) -> term.Motion:
    """Motion of a port that moves factor times as fast as the motor. course : of the companion that is read; transform
    : of the motion, with its memory as the motion itself drives it."""
    x, v, a = motion.position, motion.speed, motion.acceleration
    if factor != 1.0:
        x, v, a = factor * x, factor * v, factor * a
    m = term.Motion(x, v, a, np.sign(v), t, np.zeros((0, len(t))))
    if course is not None:
        m.w, m.dw, m.ddw = course.at(t)
    if transform is None:
        return m
    changing, p = transform
    memory = simulate_internal_states(changing, m, p, float(t[1] - t[0])) if changing.states else m.z
    return m.moved(*changing.transform(m.remembering(memory, m.side), p))
