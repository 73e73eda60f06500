"""Drag that grows with the square of the speed."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class QuadraticFriction(Term):
    """Churning of a lubricant, drag of air. Shows itself as friction that grows faster than the speed."""

    name = "quadratic_friction"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (Parameter("Fq", "Nm s2/rad2", "quadratic drag", guess=0.0, bounds=(-1e6, 1e6), null=0.0),)
    formula = "Fq v |v|"
    source = "Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30(7) (drag at high speed)"
    signature = "friction that grows faster than the speed"
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return p[0] * m.v * m.v * m.s

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        square = m.v * m.v
        return Partials(v=2.0 * p[0] * m.v * m.s, s=p[0] * square, theta=(square * m.s,))
