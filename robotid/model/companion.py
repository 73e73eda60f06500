"""Companions: further recorded signals that may explain a joint, such as the angle of another axis or a temperature."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

import numpy as np

from robotid.model.array import Array


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
class Course:
    """A companion in time. samples (3, n) : its value and the first two derivatives of it, at times begin + k
    sampling_time [s]; between them it is linear, before and after them constant."""

    samples: Array
    sampling_time: float
    begin: float = 0.0

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
        last = self.samples.shape[1] - 1
        # fmin and fmax, for the instant of a crossing is nan where an iterate overflows
        position = np.fmax(np.fmin((t - self.begin) / self.sampling_time, float(last)), 0.0)
        k = np.minimum(position.astype(np.intp), max(last - 1, 0))
        samples = self.samples[:rows]
        return samples[:, k], samples[:, np.minimum(k + 1, last)], position - k

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
    """Companions at times t (n,), each worked out once: value, rate and acceleration (3, n) by name."""

    courses: Mapping[str, Course]
    t: Array
    known: dict[str, Array] = field(default_factory=dict)

    @property
    def motor_angle(self) -> Array:
        """The recorded angle of the motor, (n,)."""
        if MOTOR_ANGLE not in self.known:
            self.known[MOTOR_ANGLE] = self.courses[MOTOR_ANGLE].value(self.t)
        return self.known[MOTOR_ANGLE]

    def __call__(self, name: str) -> Array:
        if name not in self.known:
            self.known[name] = self.courses[name].at(self.t)
        return self.known[name]


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
