"""Stribeck friction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class Stribeck(Term):
    """Friction above the Coulomb level that fades as speed builds up a lubricant film.

    Shows itself as torque missing at small speed only.
    """

    name = "stribeck"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (
        # Not zero: there the fit could not see vs.
        Parameter("dFs", "Nm", "break-away above Coulomb friction", guess=0.1, bounds=(0.0, 1e6), null=0.0),
        Parameter(
            "vs",
            "rad/s",
            "Stribeck speed",
            guess=1.0,
            bounds=(1e-4, 1e3),
            grid=(0.03, 0.1, 0.3, 1.0, 3.0, 10.0),
            physical=Physical("the motion never reaches it", within_speed=True),
        ),
    )
    formula = "dFs exp(-(v/vs)^2) sgn(v)"
    source = "Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), Gaussian form"
    signature = "torque missing at small speed only"
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        dFs, vs = p
        return np.asarray(dFs * np.exp(-((m.v / vs) ** 2)) * m.s)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        dFs, vs = p
        ratio = m.v / vs
        level = np.exp(-(ratio**2))
        steep = 2.0 * dFs / vs * ratio * level * m.s
        return Partials(v=-steep, s=dFs * level, theta=(level * m.s, steep * ratio))
