"""Inertia of a lever that another axis stretches and folds, in its simplest form."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class PoseLever(Term):
    """An arm at a distance from this axis that another axis swings outwards: its lever, and with it most of the change
    of the inertia, follows the sine of the other axis' angle, or the cosine where that counts from the stretched arm.

    One amplitude carries over to poses that the records of the fit do not show, where a free wave need not. The zero
    of the companion is that of the upright or of the level arm, as robots have it; else give its column an offset.
    Shows itself as misfit that follows acceleration, more while another axis stretches the arm.
    """

    name = "pose_lever"
    ports = (Port.ARM, Port.MOTOR)
    companion = CompanionKind.ANGLE
    parameters = (
        Parameter("A", "kg m2", "amplitude", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        Parameter(
            "psi",
            "rad",
            "angle from the upright arm where the companion is zero",
            guess=0.0,
            bounds=(-pi, pi),
            grid=(0.0, pi / 2),
            estimated=False,
        ),
    )
    formula = "J a + dJ/dt v with J = A sin(w + psi)"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.3 (two-link arm)"
    signature = "misfit that follows acceleration, more while another axis stretches the arm"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        A, psi = p
        return np.asarray(A * (np.sin(m.w + psi) * m.a + np.cos(m.w + psi) * m.dw * m.v))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        A, psi = p
        sine, cosine, turned = np.sin(m.w + psi), np.cos(m.w + psi), m.dw * m.v
        return Partials(
            v=A * cosine * m.dw,
            a=A * sine,
            theta=(sine * m.a + cosine * turned, A * (cosine * m.a - sine * turned)),
        )
