"""A drive that weakens as its supply voltage falls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class VoltageSag(Channel):
    """The torque that acts follows the supply voltage: by a share of c for each volt above w0.

    c is 1 / w0 of a drive that controls voltage, as one of pulse widths without a loop of current does, and zero of one
    whose loop of current makes up for it.
    Shows itself as torque missing while the supply voltage is low.
    """

    name = "voltage_sag"
    signals = (Signal.TORQUE,)
    companion = CompanionKind.VOLTAGE
    parameters = (
        Parameter("c", "1/V", "share of torque for each volt", guess=1e-3, bounds=(-1.0, 1.0), null=0.0),
        Parameter("w0", "V", "voltage of reference", 48.0, bounds=(-1e5, 1e5), estimated=False, centres=True),
    )
    formula = "(1 + c (w - w0)) u"
    source = "Krause, Wasynczuk & Sudhoff 2002, Analysis of Electric Machinery and Drive Systems (voltage-fed drives)"
    signature = "torque missing while the supply voltage is low"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray((1.0 + float(p[0]) * self._above(signal, p)) * signal)

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.asarray((1.0 + float(p[0]) * self._above(signal, p)) * column)

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        return np.stack([self._above(signal, p) * signal, -float(p[0]) * signal])

    def _above(self, signal: Array, p: Sequence[float]) -> Array:
        """By how much the voltage is above that of reference [V], (n,); not at all where no record is known."""
        n = signal.shape[-1]
        return np.zeros(n) if self.course is None else self.course.first(n) - float(p[1])
