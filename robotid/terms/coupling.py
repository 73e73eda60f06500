"""Inertia that another axis shares: accelerating it takes torque here."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class Coupling(Term):
    """Masses that move with this axis and with another: an entry off the diagonal of the robot's mass matrix.

    Their common momentum H(w) dw is a wave of the other axis' angle, and the torque is its whole rate, the centrifugal
    part included.
    Shows itself as misfit that follows the acceleration of another axis, also while this one rests.
    """

    name = "coupling"
    ports = (Port.ARM, Port.MOTOR)
    companion = CompanionKind.ANGLE
    parameters = (
        Parameter("H", "kg m2", "constant part", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        Parameter("A", "kg m2", "amplitude of the sine", guess=0.0, bounds=(-1e6, 1e6), null=0.0),
        Parameter("B", "kg m2", "amplitude of the cosine", guess=0.0, bounds=(-1e6, 1e6), null=0.0),
    )
    formula = "(H + A sin(w) + B cos(w)) ddw + (A cos(w) - B sin(w)) dw^2"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.1 (two-link arm)"
    signature = "misfit that follows the acceleration of another axis, also while this one rests"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        H, A, B = p
        sine, cosine = np.sin(m.w), np.cos(m.w)
        return np.asarray((H + A * sine + B * cosine) * m.ddw + (A * cosine - B * sine) * m.dw**2)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        sine, cosine = np.sin(m.w), np.cos(m.w)
        return Partials(theta=(m.ddw, sine * m.ddw + cosine * m.dw**2, cosine * m.ddw - sine * m.dw**2))
