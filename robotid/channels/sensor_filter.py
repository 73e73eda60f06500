"""First-order filter of a sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class SensorFilter(Channel):
    """The measured signal was recorded through a low-pass filter, as drives smooth the speed that they show.

    The filter is the usual one of a sampled signal, y[k] = y[k - 1] + h / (T + h) (x[k] - y[k - 1]). Before the record
    it rests at the first value. Shows itself as a lag between torque and motion, and a motion that is smaller at high
    frequency.
    """

    name = "sensor_filter"
    signals = (Signal.SPEED, Signal.ANGLE)
    is_late = True
    # The guess lies off the bound, so that either direction is open; at zero the derivative exists to the right.
    parameters = (Parameter("T", "s", "time constant of the filter", guess=1e-3, bounds=(0.0, 1.0), null=0.0),)
    formula = "T dy/dt + y = x"
    source = (
        "Astrom & Wittenmark 1997, Computer-Controlled Systems, chapter 8 (first-order filter by backward differences)"
    )
    signature = "a lag between torque and motion, and a motion that is smaller at high frequency"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray(signal - p[0] / sampling_time * _change(signal, sampling_time, p[0]))

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return self.apply(column, sampling_time, p)

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        change = _change(signal, sampling_time, p[0])
        return np.asarray(-_filtered(change, sampling_time, p[0])[None] / sampling_time)


def _change(signal: Array, sampling_time: float, T: float) -> Array:
    """What the filter's output changes by from sample to sample; nothing before the first."""
    return _filtered(np.diff(signal, axis=-1, prepend=signal[..., :1]), sampling_time, T)


def _filtered(signal: Array, sampling_time: float, T: float) -> Array:
    """The output of the filter, at rest at zero."""
    from scipy.signal import lfilter  # late: half a second, which reading a configuration need not wait for

    share = sampling_time / (T + sampling_time)
    return np.asarray(lfilter([share], [1.0, share - 1.0], signal, axis=-1))
