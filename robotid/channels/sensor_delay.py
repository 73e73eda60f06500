"""Delay of a sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.delay import delayed
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class SensorDelay(Channel):
    """The measured signal is late, by any time: linear between samples, the first value before the record.

    Shows itself as a lag between torque and motion, as that of torque_delay.
    """

    name = "sensor_delay"
    signals = (Signal.SPEED, Signal.ANGLE)
    is_late = True
    # The guess starts off the bound, so that either direction is open, and off whole samples of usual rates.
    parameters = (Parameter("Td", "s", "delay", guess=7.3e-4, bounds=(0.0, 1.0), null=0.0),)
    formula = "y(t - Td)"
    source = "Weigand, Ulmen, Janot & Ruskowski 2021 (speed and second encoder of an industrial robot)"
    signature = "a lag between torque and motion, as that of torque_delay"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return delayed(signal, p[0] / sampling_time)[0]

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return self.apply(column, sampling_time, p)

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray(delayed(signal, p[0] / sampling_time)[1][None] / sampling_time)
