"""Linear spring."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Role, Term


class Spring(Term):
    """Stiffness of gear or link. Shows itself as notch and resonance frequency."""

    name = "spring"
    ports = (Port.GEAR, Port.LINK)
    parameters = (Parameter("k1", "Nm/rad", "stiffness", guess=1e6, bounds=(1e-3, 1e9)),)
    formula = "k1 x"
    source = "Wernholt & Gunnarsson 2005, eq. (6)"
    signature = "notch and resonance frequency"
    linear = True
    role = Role.SPRING

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.x

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(x=p[0], theta=(m.x,))
