"""Viscous friction that depends on the direction of motion."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class AsymmetricViscous(Term):
    """Half the difference of viscous friction forwards and backwards.

    Shows itself as a slope over speed that differs by direction.
    """

    name = "asymmetric_viscous"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (
        Parameter("dFv", "Nm s/rad", "half of Fv forwards less Fv backwards", guess=0.0, bounds=(-1e7, 1e7), null=0.0),
    )
    formula = "dFv abs(v)"
    source = "Janot, Gautier & Brunot 2019, Data set and reference models of EMPS"
    signature = "a slope over speed that differs by direction"
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.v * m.s

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(v=p[0] * m.s, s=p[0] * m.v, theta=(m.v * m.s,))
