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

    On the axis that carries the other one, the common inertia is a wave of the other's angle (n = 0): of the momentum
    H(w) dw the torque is the whole rate, the centrifugal part included. On the axis that is carried it is a wave of its
    own angle (n = 1), which changes the inertia of the carrying axis by twice as much: by Lagrange's equations
    H(x) ddw - dH/dx dw^2.
    Shows itself as misfit that follows the acceleration of another axis, also while this one rests.
    """

    name = "coupling"
    ports = (Port.ARM, Port.MOTOR)
    companion = CompanionKind.ANGLE
    parameters = (
        Parameter("H", "kg m2", "constant part", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        # Not zero both: there the fit could not see n.
        Parameter("A", "kg m2", "amplitude of the sine", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        Parameter("B", "kg m2", "amplitude of the cosine", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        Parameter(
            "n",
            "1",
            "0 where the other axis' angle decides, 1 where this axis' own does",
            guess=0.0,
            bounds=(0.0, 1.0),
            grid=(0.0, 1.0),
            estimated=False,
        ),
    )
    formula = "(H + A sin(y) + B cos(y)) ddw + (1 - 2 n) (A cos(y) - B sin(y)) dw^2 with y = w + n (x - w)"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.1 (two-link arm)"
    signature = "misfit that follows the acceleration of another axis, also while this one rests"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        H, A, B, n = p
        y = m.w + n * (m.x - m.w)
        wave, slope = A * np.sin(y) + B * np.cos(y), A * np.cos(y) - B * np.sin(y)
        return np.asarray((H + wave) * m.ddw + (1.0 - 2.0 * n) * slope * m.dw**2)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        _, A, B, n = p
        y, sign = m.w + n * (m.x - m.w), 1.0 - 2.0 * n
        sine, cosine = np.sin(y), np.cos(y)
        wave, slope, square = A * sine + B * cosine, A * cosine - B * sine, m.dw**2
        turned = slope * m.ddw - sign * wave * square
        return Partials(
            x=n * turned,
            theta=(
                m.ddw,
                sine * m.ddw + sign * cosine * square,
                cosine * m.ddw - sign * sine * square,
                (m.x - m.w) * turned - 2.0 * slope * square,
            ),
        )
