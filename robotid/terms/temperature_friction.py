"""Friction that a recorded temperature changes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Reading, Term


class TemperatureFriction(Term):
    """Grease that thins as it warms: all friction at the port by a share of c more for each degree above w0.

    Shows itself as friction that follows a temperature.
    """

    name = "temperature_friction"
    ports = (Port.MOTOR, Port.ARM)
    companion = CompanionKind.TEMPERATURE
    parameters = (
        Parameter("c", "1/degC", "share of friction for each degree", guess=-0.01, bounds=(-1.0, 1.0), null=0.0),
        # What friction is elsewhere, the other parameters say.
        Parameter("w0", "degC", "temperature of reference", 30.0, bounds=(-273.15, 1e3), estimated=False, centres=True),
    )
    formula = "c (w - w0) (Fc sgn(v) + Fv v + ...)"
    source = "Simoni, Beschi, Legnani & Visioli 2015, IROS (friction of industrial robots with temperature effects)"
    signature = "friction that follows a temperature"
    reads = Reading(friction=True)
    friction = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        c, w0 = p
        return np.asarray(c * (m.w - w0) * m.tau)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        c, w0 = p
        warmer = m.w - w0
        return Partials(tau=c * warmer, theta=(warmer * m.tau, -c * np.asarray(m.tau)))
