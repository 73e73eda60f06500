"""Delay of a sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class SensorDelay(Channel):
    """The measured signal is late, by any time: linear between samples, the first value before the record.

    Shows itself as a lag between torque and motion, as that of torque_delay.
    """

    name = "sensor_delay"
    signals = (Signal.SPEED, Signal.ANGLE)
    # The guess starts off the bound, so that either direction is open, and off whole samples of usual rates.
    parameters = (Parameter("Td", "s", "delay", guess=7.3e-4, bounds=(0.0, 1.0), null=0.0),)
    formula = "y(t - Td)"
    source = "Weigand, Ulmen, Janot & Ruskowski 2021 (speed and second encoder of an industrial robot)"
    signature = "a lag between torque and motion, as that of torque_delay"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        later, earlier, share = _neighbours(signal, float(p[0]) / sampling_time)
        return np.asarray(later + share * (earlier - later))

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return self.apply(column, sampling_time, p)

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        later, earlier, _ = _neighbours(signal, float(p[0]) / sampling_time)
        return np.asarray((earlier - later)[None] / sampling_time)


def _neighbours(signal: Array, delay: float) -> tuple[Array, Array, float]:
    """The two samples that a delayed one lies between, and the share of the earlier. delay : in samples."""
    whole = int(delay)
    at = np.arange(signal.shape[-1]) - whole
    return signal[..., np.maximum(at, 0)], signal[..., np.maximum(at - 1, 0)], delay - whole
