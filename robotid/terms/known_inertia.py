"""Inertia that a model of the whole robot computes from the pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class KnownInertia(Term):
    """An inertia that changes with the pose as a model of the whole robot computes it: of robot.body, or elsewhere.

    Its rate times the speed is not part of it: it belongs to the known torque, with gravity and coupling.
    Shows itself as misfit that follows acceleration, more in one pose than in another.
    """

    name = "known_inertia"
    ports = (Port.ARM, Port.MOTOR)
    companion = CompanionKind.INERTIA
    parameters = (Parameter("s", "1", "how much of it acts", guess=1.0, bounds=(-1e3, 1e3), null=0.0),)
    formula = "s w a"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.2 (diagonal of the inertia matrix)"
    signature = "misfit that follows acceleration, more in one pose than in another"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(p[0] * np.asarray(m.w) * m.a)

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(a=p[0] * np.asarray(m.w), theta=(np.asarray(m.w) * m.a,))
