"""Friction that varies with the angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class PositionFriction(Term):
    """A tooth that drags, a bent shaft: dry friction with n periods a turn.

    Shows itself as misfit periodic in the angle that changes sign with the direction.
    """

    name = "position_friction"
    ports = (Port.MOTOR, Port.ARM)
    parameters = (
        # Not zero both: there the fit could not see n.
        Parameter("A", "Nm", "amplitude of the sine", guess=0.01, bounds=(-1e5, 1e5), null=0.0),
        Parameter("B", "Nm", "amplitude of the cosine", guess=0.01, bounds=(-1e5, 1e5), null=0.0),
        Parameter(
            "n",
            "1",
            "periods a turn",
            guess=1.0,
            bounds=(1e-3, 1e4),
            grid=(0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0),
            turns=True,
            physical=Physical("the motion covers too few periods", periods=3.0),
        ),
    )
    formula = "(A sin(n x) + B cos(n x)) sgn(v)"
    source = "Armstrong-Helouvry 1991, Control of Machines with Friction, chapter 4 (friction against position)"
    signature = "misfit periodic in the angle that changes sign with the direction"
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        A, B, n = p
        return np.asarray((A * np.sin(n * m.x) + B * np.cos(n * m.x)) * m.s)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        A, B, n = p
        sine, cosine = np.sin(n * m.x), np.cos(n * m.x)
        slope = (A * cosine - B * sine) * m.s
        return Partials(x=n * slope, s=A * sine + B * cosine, theta=(sine * m.s, cosine * m.s, m.x * slope))
