"""Ripple of an encoder."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Signal


class EncoderRipple(Channel):
    """A disc off its centre, a resolver out of balance: the recorded angle errs with n periods a turn.

    Shows itself as ripple of the speed without a torque to cause it.
    """

    name = "encoder_ripple"
    signals = (Signal.ANGLE,)
    parameters = (
        # Not zero both: there the fit could not see n.
        Parameter("A", "rad", "amplitude of the sine", guess=1e-3, bounds=(-1.0, 1.0), null=0.0),
        Parameter("B", "rad", "amplitude of the cosine", guess=1e-3, bounds=(-1.0, 1.0), null=0.0),
        Parameter(
            "n",
            "1",
            "periods a turn",
            guess=1.0,
            bounds=(1e-3, 1e4),
            grid=(1.0, 2.0, 3.0, 4.0, 6.0, 8.0),
            physical=Physical("the motion covers too few periods", periods=3.0),
        ),
    )
    formula = "phi + A sin(n phi) + B cos(n phi)"
    source = "Hanselman 1990, IEEE Trans. Industrial Electronics 37(6) (imbalance and harmonics of resolvers)"
    signature = "ripple of the speed without a torque to cause it"

    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        A, B, n = p
        return np.asarray(signal + A * np.sin(n * signal) + B * np.cos(n * signal))

    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        A, B, n = p
        return np.asarray(column * (1.0 + n * (A * np.cos(n * signal) - B * np.sin(n * signal))))

    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        A, B, n = p
        sine, cosine = np.sin(n * signal), np.cos(n * signal)
        return np.stack([sine, cosine, signal * (A * cosine - B * sine)])
