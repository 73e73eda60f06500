"""Companions as recorded: values on the samples of a record, and their derivatives without phase error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind, Course
from robotid.signals.differentiate import (
    bandwidth,
    central_difference,
    low_pass,
    second_difference,
    transform_length,
)

MARGIN = 4.0  # cut-off over the band of the speed, so that the filter takes noise and not motion
ENERGY_SHARE = 0.99  # of a speed, that its band holds
EDGE_MARGIN = 2.0  # cut-off over the band of the acceleration that stands out of the noise
ACCELERATION_SHARE = 0.999  # of its energy, that this band holds
STANDS_OUT = 3.0  # power of a motion over that of its noise
NEIGHBOURS = 33  # lines of the spectrum over which power is averaged
SHORTEST = 3  # samples that have derivatives

UNITS: Mapping[CompanionKind, str] = {
    CompanionKind.ANGLE: "rad",
    CompanionKind.TEMPERATURE: "degC",
    CompanionKind.TORQUE: "Nm",
    CompanionKind.VOLTAGE: "V",
    CompanionKind.INERTIA: "kg m2",
    CompanionKind.DRIVE: "Nm",
    CompanionKind.DISTURBANCE: "Nm",
}
"""In what each kind is kept."""


@dataclass(frozen=True, slots=True, eq=False)
class Companion:
    """A further signal of a record, (n,) in the unit. speed, acceleration : the first two derivatives of an angle,
    zero-phase, None of what is not differentiated."""

    kind: CompanionKind
    unit: str
    values: Array = field(metadata={"unit_in": "unit", "shape": ("n",), "finite": True})
    speed: Array | None = field(default=None, metadata={"unit": "rad/s", "shape": ("n",), "finite": True})
    acceleration: Array | None = field(default=None, metadata={"unit": "rad/s2", "shape": ("n",), "finite": True})

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
    """Speed and acceleration of an angle (n,), through a zero-phase filter that leaves the band of its speed alone, and
    the band of what stands out of the noise in its acceleration, of which fast and small motion may be the most."""
    speed = central_difference(angle, sampling_time)
    lowest = 1.0 / (len(angle) * sampling_time)
    band = max(lowest, bandwidth(speed, sampling_time, ENERGY_SHARE))
    smooth = low_pass(angle, sampling_time, max(MARGIN * band, EDGE_MARGIN * acceleration_band(angle, sampling_time)))
    return central_difference(smooth, sampling_time), second_difference(smooth, sampling_time)


def acceleration_band(angle: Array, sampling_time: float) -> float:
    """Frequency [Hz] below which the energy of an angle's acceleration lies, what does not stand out of the angle's
    noise left out; zero for a record too short to tell.

    angle : (n,), with white noise that is alone in the upper quarter of the spectrum.
    """
    n = transform_length(len(angle))
    if n < 8 * NEIGHBOURS:
        return 0.0
    change = np.diff(angle[:n], 2)
    frequency = np.fft.rfftfreq(len(change), sampling_time)
    power = np.abs(np.fft.rfft(change * np.blackman(len(change)))) ** 2
    gain = (2.0 * np.sin(np.pi * frequency * sampling_time)) ** 4  # of white noise in second differences
    upper, even = slice(3 * len(power) // 4, None), np.full(NEIGHBOURS, 1.0 / NEIGHBOURS)
    noise = gain * (power[upper].mean() / gain[upper].mean())
    energy = np.cumsum(np.where(np.convolve(power - STANDS_OUT * noise, even, "same") > 0.0, power, 0.0))
    return float(frequency[np.searchsorted(energy, ACCELERATION_SHARE * energy[-1])]) if energy[-1] > 0.0 else 0.0


def together(pieces: Sequence[Companion]) -> Companion:
    """Consecutive pieces of a companion as one."""

    def whole(name: str) -> Array | None:
        parts = [getattr(one, name) for one in pieces]
        return None if parts[0] is None else np.concatenate(parts)

    values = np.concatenate([one.values for one in pieces])
    return replace(pieces[0], values=values, speed=whole("speed"), acceleration=whole("acceleration"))
