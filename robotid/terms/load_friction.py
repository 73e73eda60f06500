"""Friction that grows with the torque that the gear transmits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Reading, Term


class LoadFriction(Term):
    """Teeth and rollers pressed together: dry friction in proportion to the gear's torque, seen from the motor.

    Shows itself as friction that grows with the transmitted torque.
    """

    name = "load_friction"
    ports = (Port.MOTOR,)
    parameters = (Parameter("mu", "1", "friction per transmitted torque", guess=0.01, bounds=(0.0, 1.0), null=0.0),)
    formula = "mu |r tau_gear| sgn(v)"
    source = "Hamon, Gautier & Garrec 2010, IROS (dry friction with load); Wernholt & Gunnarsson 2005, section 6.3"
    signature = "friction that grows with the transmitted torque"
    friction = True
    reads = Reading(Port.GEAR)

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(p[0] * m.tau * _way(m) * m.s)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        load = m.tau * _way(m)
        return Partials(s=p[0] * load, tau=p[0] * _way(m) * m.s, theta=(load * m.s,))


def _way(m: Motion) -> Array:
    """Sign of the gear's torque, (n,)."""
    return np.asarray(np.sign(m.tau.real))
