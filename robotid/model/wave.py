"""The mechanics of a torque that is a sine and a cosine of a position."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.term import Motion, Partials, Term


class Wave(Term):
    """A torque A sin(n x) + B cos(n x), by three parameters in the order A, B [Nm], n."""

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        A, B, n = p
        return np.asarray(A * np.sin(n * m.x) + B * np.cos(n * m.x))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        A, B, n = p
        sine, cosine = np.sin(n * m.x), np.cos(n * m.x)
        slope = A * cosine - B * sine
        return Partials(x=n * slope, theta=(sine, cosine, m.x * slope))
