"""Saturation of the torque."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.port import Signal

SMALL = 1e-2  # of c u^2, below which a series is exact and the formula is not


class TorqueSaturation(Channel):
    """The torque that acts stays behind the recorded one as iron saturates, and never exceeds usat.

    Its parameter is c = 1 / usat^2, for without saturation its first power is the first that shows: u - c u^3 / 3 + ...
    Shows itself as torque missing at large torque.
    """

    name = "torque_saturation"
    signals = (Signal.TORQUE,)
    parameters = (
        Parameter("c", "1/Nm2", "inverse square of the largest torque", guess=1e-4, bounds=(0.0, 1e6), null=0.0),
    )
    formula = "usat tanh(u / usat), usat = 1 / sqrt(c)"
    source = "Krause, Wasynczuk & Sudhoff 2002, Analysis of Electric Machinery and Drive Systems (saturation)"
    signature = "torque missing at large torque"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray(signal * _gain(float(p[0]) * signal**2)[0])

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        y = float(p[0]) * signal**2
        gain, slope = _gain(y)
        return np.asarray(column * (gain + 2.0 * y * slope))

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray((signal**3 * _gain(float(p[0]) * signal**2)[1])[None])


def _gain(y: Array) -> tuple[Array, Array]:
    """tanh(sqrt(y)) / sqrt(y) and its derivative, (n,) each, smooth through zero."""
    series = 1.0 + y * (-1 / 3 + y * (2 / 15 + y * (-17 / 315 + y * (62 / 2835 - y * 1382 / 155925))))
    slope = -1 / 3 + y * (4 / 15 + y * (-17 / 105 + y * (248 / 2835 - y * 1382 / 31185)))
    root = np.sqrt(np.maximum(y, SMALL))
    level = np.tanh(root)
    return np.where(y < SMALL, series, level / root), np.where(
        y < SMALL, slope, (1.0 - level**2 - level / root) / (2.0 * root**2)
    )
