"""Inertia that another axis changes by its angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class PoseInertia(Term):
    """An arm that another axis stretches and folds: part of its inertia is a wave of that axis' angle.

    The momentum J(w) v changes with v and with w, and its own angle does not enter J: by Lagrange's equations the
    torque is its whole rate, J(w) a + dJ/dw dw v.
    Shows itself as misfit that follows acceleration, more in one pose of another axis than in another.
    """

    name = "pose_inertia"
    ports = (Port.ARM, Port.MOTOR)
    companion = CompanionKind.ANGLE
    parameters = (
        # Not zero both: there the fit could not see n.
        Parameter("A", "kg m2", "amplitude of the sine", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        Parameter("B", "kg m2", "amplitude of the cosine", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        # A lever that turns is a sine of the angle, and its square, an inertia, one of twice the angle.
        Parameter("n", "1", "periods a turn", guess=1.0, bounds=(1.0, 4.0), grid=(1.0, 2.0), estimated=False),
    )
    formula = "J a + dJ/dt v with J = A sin(n w) + B cos(n w)"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.1 (two-link arm)"
    signature = "misfit that follows acceleration, more in one pose of another axis than in another"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        inertia, slope, _ = _inertia(m, p)
        return np.asarray(inertia * m.a + slope * m.dw * m.v)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        n = p[2]
        inertia, slope, bow = _inertia(m, p)
        sine, cosine = np.sin(n * m.w), np.cos(n * m.w)
        spin = n * m.dw * m.v
        turned = m.w * slope / n * m.a + (slope / n + m.w * bow / n) * m.dw * m.v
        return Partials(
            v=slope * m.dw, a=inertia, theta=(sine * m.a + cosine * spin, cosine * m.a - sine * spin, turned)
        )


def _inertia(m: Motion, p: Sequence[float]) -> tuple[Array, Array, Array]:
    """The inertia, and its first and second derivative to the companion, (n,) each."""
    A, B, n = p
    sine, cosine = np.sin(n * m.w), np.cos(n * m.w)
    inertia = A * sine + B * cosine
    return inertia, n * (A * cosine - B * sine), -n * n * inertia
