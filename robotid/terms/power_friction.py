"""Friction that grows with a power of the speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term

SLOWEST = 1e-2  # rad/s, below which the law is a straight line: a power below one has no slope at rest


class PowerFriction(Term):
    """Grease and cold gears: |v|^alpha sgn(v), a straight line below a creeping speed.

    Shows itself as friction that grows slower than the speed.
    """

    name = "power_friction"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (
        # Not zero: there the fit could not see alpha.
        Parameter("Fp", "Nm", "friction at 1 rad/s", guess=0.01, bounds=(-1e6, 1e6), null=0.0),
        Parameter(
            "alpha",
            "1",
            "power",
            guess=0.5,
            bounds=(0.01, 2.0),
            grid=(0.2, 0.35, 0.5, 0.65, 0.8, 1.25, 1.5, 1.75),
            barrier=1.0,  # viscous friction
        ),
    )
    formula = "Fp |v|^alpha sgn(v)"
    source = "Wernholt & Moberg 2011, Automatica 47(6)"
    signature = "friction that grows slower than the speed"
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        Fp, alpha = p
        return np.asarray(Fp * m.v * (m.v * m.v + SLOWEST**2) ** ((alpha - 1.0) / 2.0))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        Fp, alpha = p
        square = m.v * m.v + SLOWEST**2
        power = square ** ((alpha - 1.0) / 2.0)
        slope = Fp * power * (1.0 + (alpha - 1.0) * m.v * m.v / square)
        return Partials(v=slope, theta=(m.v * power, 0.5 * Fp * m.v * power * np.log(square)))
