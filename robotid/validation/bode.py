"""The linearised model beside the measured frequency responses: Figures 2 and 3 of the paper."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.linear import channel_response, linearise
from robotid.signals.frf import Frf
from robotid.validation.results import Bode

FLOOR = 0.01  # relative error of a response that no noise explains


def bode(joint: Joint, theta: Array, frfs: Sequence[Frf], sampling_time: float) -> Bode | None:
    """Bode magnitudes of a joint about rest, channels included; None without measured responses."""
    if not frfs:
        return None
    linear = linearise(joint, theta)

    def speed(omega: Array) -> Array:
        return np.abs(linear.speed_response(omega) * channel_response(joint, theta, omega, sampling_time))

    frequency = np.unique(np.concatenate([frf.frequency for frf in frfs]))
    magnitude = speed(2 * np.pi * frequency)
    return Bode(
        frequency=frequency,
        acceleration=2 * np.pi * frequency * magnitude,
        speed=magnitude,
        distance={frf.record: magnitude_distance(speed(frf.omega), frf) for frf in frfs},
    )


def magnitude_distance(model: Array, frf: Frf) -> float:
    """RMS of the ratio of a model's magnitude (n,), torque to speed, to a measured one [dB], over the lines at which
    that is not zero."""
    shown = frf.response != 0.0
    weight = 1 / ((frf.std[shown] / np.abs(frf.response[shown])) ** 2 + FLOOR**2)
    ratio = 20 * np.log10(model[shown] / np.abs(frf.speed_response[shown]))
    return float(np.sqrt(weight @ ratio**2 / weight.sum()))
