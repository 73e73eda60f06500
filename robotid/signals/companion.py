"""Companions as recorded: values on the samples of a record, and their derivatives without phase error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind, Course
from robotid.signals.differentiate import bandwidth, central_difference, low_pass, second_difference

MARGIN = 4.0  # cut-off over the band of the speed, so that the filter takes noise and not motion
ENERGY_SHARE = 0.99  # of a speed, that its band holds
SHORTEST = 3  # samples that have derivatives

UNITS: Mapping[CompanionKind, str] = {
    CompanionKind.ANGLE: "rad",
    CompanionKind.TEMPERATURE: "degC",
    CompanionKind.TORQUE: "Nm",
    CompanionKind.VOLTAGE: "V",
    CompanionKind.DISTURBANCE: "Nm",
}
"""In what each kind is kept."""


@dataclass(frozen=True, slots=True, eq=False)
class Companion:
    """A further signal of a record, (n,) in the unit. speed, acceleration : the first two derivatives of an angle,
    zero-phase, None of what is not differentiated."""

    kind: CompanionKind
    unit: str
    values: Array = field(metadata={"unit_in": "unit"})
    speed: Array | None = field(default=None, metadata={"unit": "rad/s"})
    acceleration: Array | None = field(default=None, metadata={"unit": "rad/s2"})

    @classmethod
    def of(cls, kind: CompanionKind, values: Array, sampling_time: float, unit: str = "") -> Companion:
        """A companion of values (n,) at every sampling_time [s]. unit : by default the usual one of its kind."""
        unit = unit or UNITS[kind]
        if kind is not CompanionKind.ANGLE or len(values) < SHORTEST:
            return cls(kind, unit, values)
        return cls(kind, unit, values, *derivatives(values, sampling_time))

    def course(self, sampling_time: float, begin: float) -> Course:
        """The companion in time."""
        nothing = np.zeros(len(self.values))
        derived = (nothing if one is None else one for one in (self.speed, self.acceleration))
        return Course(np.stack([self.values, *derived]), sampling_time, begin)

    def piece(self, first: int, last: int, step: int = 1) -> Companion:
        """Its samples first .. last - 1, or every step-th of them."""
        at = slice(first, last, step)
        return replace(
            self,
            values=self.values[at],
            speed=None if self.speed is None else self.speed[at],
            acceleration=None if self.acceleration is None else self.acceleration[at],
        )


def derivatives(angle: Array, sampling_time: float) -> tuple[Array, Array]:
    """Speed and acceleration of an angle (n,), through a zero-phase filter that leaves the band of its speed alone."""
    speed = central_difference(angle, sampling_time)
    lowest = 1.0 / (len(angle) * sampling_time)
    band = max(lowest, bandwidth(speed, sampling_time, ENERGY_SHARE))
    smooth = low_pass(angle, sampling_time, MARGIN * band)
    return central_difference(smooth, sampling_time), second_difference(smooth, sampling_time)


def together(pieces: Sequence[Companion]) -> Companion:
    """Consecutive pieces of a companion as one."""

    def whole(name: str) -> Array | None:
        parts = [getattr(one, name) for one in pieces]
        return None if parts[0] is None else np.concatenate(parts)

    values = np.concatenate([one.values for one in pieces])
    return replace(pieces[0], values=values, speed=whole("speed"), acceleration=whole("acceleration"))
