"""Friction of a cold gear that warms up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Reading, Term


class ThermalFriction(Term):
    """More friction at the start of an experiment than at its end: a share c of all friction at the port that fades.

    Shows itself as friction that fades along the record.
    """

    name = "thermal_friction"
    ports = (Port.MOTOR, Port.ARM)
    parameters = (
        # Not zero: there the fit could not see T.
        Parameter("c", "1", "share of friction that fades", guess=0.1, bounds=(-0.9, 9.0), null=0.0),
        Parameter(
            "T",
            "s",
            "time constant",
            guess=10.0,
            bounds=(1e-2, 1e5),
            grid=(1.0, 3.0, 10.0, 30.0, 100.0, 300.0),
            physical=Physical("nothing warms up so fast", least=2.0, of_duration=0.2, enough=10.0),
        ),
    )
    formula = "c exp(-t/T) (Fc sgn(v) + Fv v + ...)"
    source = (
        "Carvalho Bittencourt, Wernholt, Sander-Tavallaey & Brogardh 2010, IROS (friction of a robot that warms up)"
    )
    signature = "friction that fades along the record"
    reads = Reading(friction=True)
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(p[0] * np.exp(-m.t / p[1]) * m.tau)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        c, T = p
        fading = np.exp(-m.t / T)
        return Partials(tau=c * fading, theta=(fading * m.tau, c * fading * m.t / T**2 * m.tau))
