"""Damper beside a spring."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Role, Term


class Damper(Term):
    """Torque proportional to the rate of twist. Shows itself as the height of the resonance."""

    name = "damper"
    ports = (Port.GEAR, Port.LINK)
    parameters = (Parameter("d", "Nm s/rad", "damping", guess=1e3, bounds=(0.0, 1e8), null=0.0),)
    formula = "d v"
    source = "Wernholt & Gunnarsson 2005, eq. (4)"
    signature = "the height of the resonance"
    linear = True
    role = Role.DAMPER

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.v

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(v=p[0], theta=(m.v,))
