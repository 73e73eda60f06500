"""Coulomb friction."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class Coulomb(Term):
    """Dry friction: constant against the motion, any torque up to its level at rest.

    Shows itself as a square wave that jumps at reversals.
    """

    name = "coulomb"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (Parameter("Fc", "Nm", "Coulomb friction level", guess=0.5, bounds=(0.0, 1e6), null=0.0),)
    formula = "Fc sgn(v)"
    source = "Wernholt & Gunnarsson 2005, eq. (7)"
    signature = "a square wave that jumps at reversals"
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.s

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(s=p[0], theta=(m.s,))
