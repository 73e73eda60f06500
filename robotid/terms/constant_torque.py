"""Constant torque."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class ConstantTorque(Term):
    """A torque that is always there: an offset of the amplifier, a balancing weight or hose.

    Shows itself as a mean of the missing torque, also at rest.
    """

    name = "constant_torque"
    ports = (Port.MOTOR, Port.ARM, Port.TOOL)
    parameters = (Parameter("tau0", "Nm", "constant torque", guess=0.0, bounds=(-1e6, 1e6), null=0.0),)
    formula = "tau0"
    source = "Janot, Gautier & Brunot 2019, Data set and reference models of EMPS (offset)"
    signature = "a mean of the missing torque, also at rest"

    def torque(self, m: Motion, p: Sequence[float]) -> float:
        return p[0]

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(theta=(1.0,))
