"""First-order filter through which the torque was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Self

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class TorqueFilter(Channel):
    """The torque was recorded through a low-pass filter, as drives smooth the current that they show.

    The filter is the usual one of a sampled signal, y[k] = y[k - 1] + h / (T + h) (u[k] - y[k - 1]), whose inverse is
    linear in T. Before the record the torque rests at its first value. Nothing in a machine is early. Shows itself as a
    torque that acts before it is recorded, and is larger at high frequency.
    """

    name = "torque_filter"
    signals = (Signal.TORQUE,)
    parameters = (Parameter("T", "s", "time constant of the filter", guess=1e-3, bounds=(0.0, 1.0), null=0.0),)
    formula = "u_eff = u + T du/dt"
    source = (
        "Astrom & Wittenmark 1997, Computer-Controlled Systems, chapter 8 (first-order filter by backward differences)"
    )
    signature = "a torque that acts before it is recorded, and is larger at high frequency"
    parts: int = 1  # samples of an interval of the filter

    def on_parts(self, parts: int) -> Self:
        one = copy(super().on_parts(parts))
        one.parts = parts
        return one

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray(signal + p[0] * self._slope(signal, sampling_time))

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return self.apply(column, sampling_time, p)

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return self._slope(signal, sampling_time)[None]

    def _slope(self, signal: Array, sampling_time: float) -> Array:
        """Backward differences over the filter's interval."""
        lead = np.repeat(signal[..., :1], self.parts, axis=-1)
        before = np.concatenate([lead, signal[..., : -self.parts]], axis=-1)
        return np.asarray((signal - before) / (self.parts * sampling_time))
