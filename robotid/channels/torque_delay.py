"""Delay of the torque."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.delay import delayed
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class TorqueDelay(Channel):
    """The torque acts later than it is recorded, by any time, not only by whole samples.

    A torque that is constant between samples and delayed by k + f samples takes, in interval n, the value n - k - 1
    for the share f and then n - k. Before the record the torque rests at its first value. Shows itself as phase loss
    that grows with frequency, without loss of gain.
    """

    name = "torque_delay"
    signals = (Signal.TORQUE,)
    has_memory = True
    is_late = True
    # The guess lies off the bound, and off the multiples of usual sampling times, where the derivative jumps: there, as
    # at zero, `partials` gives the one to the right.
    parameters = (Parameter("Td", "s", "delay", guess=7.3e-4, bounds=(0.0, 1.0), null=0.0),)
    formula = "u(t - Td)"
    source = "Astrom & Wittenmark 1997, Computer-Controlled Systems, chapter 2"
    signature = "phase loss that grows with frequency, without loss of gain"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return delayed(signal, p[0] / sampling_time)[0]

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return self.apply(column, sampling_time, p)

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray(delayed(signal, p[0] / sampling_time)[1][None] / sampling_time)
