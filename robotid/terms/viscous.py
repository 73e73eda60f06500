"""Viscous friction."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class Viscous(Term):
    """Friction of a lubricated contact, proportional to speed. Shows itself as misfit that follows speed."""

    name = "viscous"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (Parameter("Fv", "Nm s/rad", "viscous friction", guess=0.01, bounds=(0.0, 1e7), null=0.0),)
    formula = "Fv v"
    source = "Wernholt & Gunnarsson 2005, eq. (7)"
    signature = "misfit that follows speed"
    friction = True
    linear = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.v

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(v=p[0], theta=(m.v,))
