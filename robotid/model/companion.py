"""Companions: further recorded signals that may explain a joint, such as the angle of another axis or a temperature."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

import numpy as np

from robotid.model.array import Array, Index, taken


class CompanionKind(StrEnum):
    """What a companion measures. A disturbance is the part of the recorded torque that the controller did not command;
    it is in the torque already, and no effect reads it. A drive is the torque of another axis, which the body of the
    robot is identified from; no effect reads it either."""

    ANGLE = "angle"
    TEMPERATURE = "temperature"
    TORQUE = "torque"
    VOLTAGE = "voltage"
    INERTIA = "inertia"
    DRIVE = "drive"
    DISTURBANCE = "disturbance"


@dataclass(frozen=True, slots=True, eq=False)
class Turns:
    """Several recordings in one time: what happens at t in recording k happens there at k turn + t.

    turn [s] : longer than any of them; begin [s], first, last (k,) : of each, when its samples begin, where they stand
    among those of all, and the number of its last one.
    """

    turn: float
    begin: Array
    first: Index
    last: Index

    def own(self, t: Array) -> tuple[Index, Array]:
        """To which recording times t (m,) [s] belong, and the times in it, (m,)."""
        k = np.fmax(np.fmin(np.floor(t / self.turn), len(self.begin) - 1.0), 0.0)
        return k.astype(np.intp), t - self.turn * k


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A companion in time. samples (3, n) : its value and the first two derivatives of it, at times begin + k
    sampling_time [s]; between them it is linear, before and after them constant. turns : how the samples of several
    recordings follow each other, None where they are of one."""

    samples: Array
    sampling_time: float
    begin: float = 0.0
    turns: Turns | None = None

    def at(self, t: Array) -> Array:
        """Value, rate and acceleration at times t (m,) [s], (3, m)."""
        before, after, share = self._around(t)
        return np.asarray(before + share * (after - before))

    def value(self, t: Array) -> Array:
        """Value alone at times t (m,) [s], (m,)."""
        (before,), (after,), share = self._around(t, 1)
        return np.asarray(before + share * (after - before))

    def _around(self, t: Array, rows: int = 3) -> tuple[Array, Array, Array]:
        """The first samples before and after times t (m,) [s], (rows, m) each, and the share (m,) of the way between
        them."""
        samples, last = self.samples[:rows], self.samples.shape[1] - 1
        if self.turns is not None:
            return self._around_in_turns(samples, self.turns, t)
        # fmin and fmax, for the instant of a crossing is nan where an iterate overflows
        position = np.fmax(np.fmin((t - self.begin) / self.sampling_time, float(last)), 0.0)
        k = np.minimum(position.astype(np.intp), max(last - 1, 0))
        return taken(samples, k), taken(samples, np.minimum(k + 1, last)), position - k

    def _around_in_turns(self, samples: Array, turns: Turns, t: Array) -> tuple[Array, Array, Array]:
        """The same of several recordings."""
        own, t = turns.own(t)
        last, first = turns.last[own], turns.first[own]
        position = np.fmax(np.fmin((t - turns.begin[own]) / self.sampling_time, last), 0.0)
        k = np.minimum(position.astype(np.intp), np.maximum(last - 1, 0))
        return taken(samples, first + k), taken(samples, first + np.minimum(k + 1, last)), position - k

    def first(self, n: int) -> Array:
        """Value at its first n samples, (n,), the last one held."""
        return np.asarray(self.samples[0, np.minimum(np.arange(n), self.samples.shape[1] - 1)])

    def in_parts(self, parts: int) -> Course:
        """The same with so many equal parts of each interval as its samples, its value held over these."""
        return Course(np.repeat(self.samples, parts, axis=1), self.sampling_time / parts, self.begin)

    @property
    def mean(self) -> float:
        """Of its value."""
        return float(self.samples[0].mean())

    @property
    def resting(self) -> Course:
        """The companion at its mean, always."""
        return Course(np.array([[self.mean], [0.0], [0.0]]), self.sampling_time, self.begin)


MOTOR_ANGLE = "phi_m"
"""The recorded angle of the motor among the companions of a joint that follows it."""


@dataclass(frozen=True, slots=True, eq=False)
class SmoothCourse(Course):
    """A companion whose value goes from sample to sample as its rate asks: Hermite's cubic."""

    def at(self, t: Array) -> Array:
        before, after, share = self._around(t)
        found = before + share * (after - before)
        found[0] += self._bend(before, after, share)
        return np.asarray(found)

    def value(self, t: Array) -> Array:
        before, after, share = self._around(t, 2)
        return np.asarray(before[0] + share * (after[0] - before[0]) + self._bend(before, after, share))

    def _bend(self, before: Array, after: Array, share: Array) -> Array:
        """What the cubic adds to the straight line, (m,)."""
        step = after[0] - before[0]
        start, end = self.sampling_time * before[1], self.sampling_time * after[1]
        return np.asarray(share * (1.0 - share) * ((1.0 - share) * (start - step) + share * (step - end)))


@dataclass(slots=True, eq=False)
class CompanionsAt:
    """Companions at times t (n,), each worked out once: value, rate and acceleration (3, n) by name, of the motor's
    angle the value (n,) alone."""

    courses: Mapping[str, Course]
    t: Array
    known: dict[str, Array] = field(default_factory=dict)
    known_angle: Array | None = None

    @property
    def time(self) -> Array:
        """Times in the recordings themselves [s], (n,)."""
        turns = next((one.turns for one in self.courses.values()), None)
        return self.t if turns is None else turns.own(self.t)[1]

    @property
    def motor_angle(self) -> Array:
        """The recorded angle of the motor, (n,)."""
        if self.known_angle is None:
            self.known_angle = self.courses[MOTOR_ANGLE].value(self.t)
        return self.known_angle

    def __call__(self, name: str) -> Array:
        if name not in self.known:
            self.known[name] = self.courses[name].at(self.t)
        return self.known[name]


def in_turns(courses: Sequence[Course], turn: float) -> Course | None:
    """The same companion beside several recordings as one, recording k from k turn [s] on; None where it is not sampled
    alike in all of them."""
    one = courses[0]
    if any(type(other) is not type(one) or other.sampling_time != one.sampling_time for other in courses):
        return None
    counts = np.array([other.samples.shape[1] for other in courses])
    begin = np.array([other.begin for other in courses])
    turns = Turns(turn, begin, np.cumsum(counts) - counts, counts - 1)
    return type(one)(np.concatenate([other.samples for other in courses], axis=1), one.sampling_time, 0.0, turns)


class Accompanied(Protocol):
    """A recording of a joint, with its companions by name. motor_course : of the motor's angle."""

    @property
    def name(self) -> str: ...

    @property
    def courses(self) -> Mapping[str, Course]: ...

    @property
    def motor_course(self) -> Course: ...


def companion_of(effect: str) -> tuple[str, str]:
    """An effect's name without the companion that it reads, and that companion: `arm.pose_inertia[q2]` ->
    `arm.pose_inertia`, `q2`; the latter empty where it reads none."""
    plain, bracket, rest = effect.partition("[")
    return plain, rest.removesuffix("]") if bracket else ""


def drive_of(axis: str) -> str:
    """The name of the torque of another axis among the companions, a signal that no effect reads."""
    return f"tau_{axis}"


def with_companion(effect: str, companion: str) -> str:
    """The name of an effect that reads a companion."""
    return f"{effect}[{companion}]"
