"""Torque that is recorded, or computed elsewhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class KnownTorque(Term):
    """A torque that acts beside that of the motor: a payload cell, pushes of a hand, gravity and coupling as a model of
    the whole robot computes them.

    It drives the joint where g is positive; fix g at 1 where the sensor is trusted.
    Shows itself as misfit that follows a recorded torque.
    """

    name = "known_torque"
    ports = (Port.ARM, Port.MOTOR, Port.TOOL)
    companion = CompanionKind.TORQUE
    parameters = (Parameter("g", "1", "how much of it acts", guess=1.0, bounds=(-1e3, 1e3), null=0.0),)
    formula = "-g w"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.3 (external forces)"
    signature = "misfit that follows a recorded torque"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(-p[0] * np.asarray(m.w))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(theta=(-np.asarray(m.w),))
