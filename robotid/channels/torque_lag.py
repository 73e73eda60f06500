"""First-order lag of the torque."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, expm1

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.port import Signal

NEGLIGIBLE = 700.0  # exp(-700) is the last that does not underflow


class TorqueLag(Channel):
    """The torque builds up exponentially, as current does in a motor or behind a current controller.

    With w the filter's output less its input at the start of each interval, the mean over the interval is
    u + (T/h) (1 - exp(-h/T)) w. Before the record the filter rests at the first value. Shows itself as phase and gain
    loss at high frequency.
    """

    name = "torque_lag"
    signals = (Signal.TORQUE,)
    has_memory = True
    is_late = True
    # The guess lies off the bound, so that either direction is open; at zero the derivative exists to the right.
    parameters = (Parameter("T", "s", "time constant", guess=1e-3, bounds=(0.0, 10.0), null=0.0),)
    formula = "T du_eff/dt + u_eff = u"
    source = "Leonhard 2001, Control of Electrical Drives (current loop as a first-order lag)"
    signature = "phase and gain loss at high frequency"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        T = float(p[0])
        decay, _ = _decay(T, sampling_time)
        return np.asarray(signal + _weight(T, sampling_time) * _lacking(signal, decay))

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return self.apply(column, sampling_time, p)

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        T, h = float(p[0]), sampling_time
        decay, slope = _decay(T, h)
        lacking = _lacking(signal, decay)
        return np.asarray((_weight_slope(T, h) * lacking + _weight(T, h) * _filter([0.0, slope], decay, lacking))[None])


def _decay(T: float, h: float) -> tuple[float, float]:
    """What is left of a deviation after one interval, exp(-h/T), and its derivative to T."""
    if h >= NEGLIGIBLE * T:
        return 0.0, 0.0
    decay = exp(-h / T)
    return decay, decay * h / T**2


def _weight(T: float, h: float) -> float:
    """Mean over an interval of a deviation that starts at one, (T/h) (1 - exp(-h/T))."""
    return T / h if h >= NEGLIGIBLE * T else -T / h * expm1(-h / T)


def _weight_slope(T: float, h: float) -> float:
    """Derivative of the weight to T; 1/h at T = 0."""
    return 1.0 / h if h >= NEGLIGIBLE * T else -expm1(-h / T) / h - exp(-h / T) / T


def _lacking(signal: Array, decay: float) -> Array:
    """The filter's output less its input at the start of each interval; zero at the first."""
    return _filter([1.0], decay, -np.diff(signal, axis=-1, prepend=signal[..., :1]))


def _filter(numerator: Sequence[float], decay: float, signal: Array) -> Array:
    from scipy.signal import lfilter  # late: half a second, which reading a configuration need not wait for

    return np.asarray(lfilter(numerator, [1.0, -decay], signal, axis=-1))
