"""A torque constant that differs from the data sheet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class TorqueGain(Channel):
    """The torque that acts is larger than recorded by a share g. Visible only beside a known inertia.

    Shows itself as every inertia and friction scaled alike.
    """

    name = "torque_gain"
    signals = (Signal.TORQUE,)
    parameters = (Parameter("g", "1", "share missing in the recorded torque", guess=0.0, bounds=(-0.9, 9.0), null=0.0),)
    formula = "(1 + g) u"
    source = "Gautier & Briot 2014, J. Dynamic Systems, Measurement and Control 136(5) (drive gains)"
    signature = "every inertia and friction scaled alike"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return (1.0 + float(p[0])) * signal

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return (1.0 + float(p[0])) * column

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray(signal[None])
