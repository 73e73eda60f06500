"""Gravity on an arm that swings out of the horizontal plane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class Gravity(Term):
    """Weight of an arm at its lever, for any zero of the angle. Shows itself as a slow function of arm angle."""

    name = "gravity"
    ports = (Port.ARM, Port.TOOL, Port.MOTOR)
    parameters = (
        Parameter(
            "G", "Nm", "weight times lever, part in sin(x)", guess=0.0, bounds=(-1e6, 1e6), null=0.0, carried=True
        ),
        Parameter(
            "H", "Nm", "weight times lever, part in cos(x)", guess=0.0, bounds=(-1e6, 1e6), null=0.0, carried=True
        ),
    )
    formula = "G sin(x) + H cos(x)"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.3"
    signature = "a slow function of arm angle"
    swings = True

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(p[0] * np.sin(m.x) + p[1] * np.cos(m.x))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        sine, cosine = np.sin(m.x), np.cos(m.x)
        return Partials(x=p[0] * cosine - p[1] * sine, theta=(sine, cosine))
