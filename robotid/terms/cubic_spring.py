"""Hardening of a spring."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Role, Term


class CubicSpring(Term):
    """Stiffness that grows with the square of the twist. Shows itself as a resonance that rises with amplitude."""

    name = "cubic_spring"
    ports = (Port.GEAR, Port.LINK)
    # Either sign: records with little twist hardly see k3, and a bound at zero would bias what they show.
    parameters = (Parameter("k3", "Nm/rad3", "cubic stiffness", guess=0.0, bounds=(-1e15, 1e15), null=0.0),)
    formula = "k3 x^3"
    source = "Wernholt & Gunnarsson 2005, eq. (6)"
    signature = "a resonance that rises with amplitude"
    role = Role.SPRING

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.x * m.x * m.x

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(x=3.0 * p[0] * m.x * m.x, theta=(m.x * m.x * m.x,))
