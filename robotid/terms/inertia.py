"""Inertia of one mass."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Role, Term


class Inertia(Term):
    """Torque that accelerates a mass. Shows itself as misfit that follows acceleration."""

    name = "inertia"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    # Positive, lest the mass matrix be singular. The guess lies between a motor's (0.01) and a large arm's (1000).
    parameters = (Parameter("J", "kg m2", "moment of inertia", guess=1.0, bounds=(1e-9, 1e8), carried=True),)
    formula = "J a"
    source = "Wernholt & Gunnarsson 2005, eq. (4), (5)"
    signature = "misfit that follows acceleration"
    linear = True
    role = Role.MASS

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.a

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(a=p[0], theta=(m.a,))
