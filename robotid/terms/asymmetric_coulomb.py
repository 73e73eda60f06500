"""Coulomb friction that depends on the direction of motion."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class AsymmetricCoulomb(Term):
    """Half the difference of Coulomb friction forwards and backwards.

    Shows itself as a constant while moving, either way.
    """

    name = "asymmetric_coulomb"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (
        Parameter("dFc", "Nm", "half of Fc forwards less Fc backwards", guess=0.0, bounds=(-1e6, 1e6), null=0.0),
    )
    formula = "dFc sgn(v)^2"
    source = "Janot, Gautier & Brunot 2019, Data set and reference models of EMPS"
    signature = "a constant while moving, either way"
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.s**2

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(s=2.0 * p[0] * m.s, theta=(m.s**2,))
