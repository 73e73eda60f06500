"""Backlash."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, MotionTransform, Partials


class Backlash(MotionTransform):
    """Play between the teeth: spring and damper see no twist inside the gap, and only what exceeds it outside.

    Shows itself as free motion inside the gap, with impacts where the torque of the gear reverses.
    """

    name = "backlash"
    ports = (Port.GEAR, Port.LINK)
    # The guess starts off the bound, where the direction to the other side would be closed.
    parameters = (Parameter("gap", "rad", "half the play", guess=1e-4, bounds=(0.0, 1.0), null=0.0),)
    formula = "others see x less what lies within gap, x - clip(x, -gap, gap), and v only while |x| > gap"
    source = "Nordin & Gutman 2002, Automatica 38(10), dead zone model"
    signature = "free motion inside the gap, with impacts where the torque of the gear reverses"
    edges = ("upper", "lower")
    follows = True
    play = True

    def distance(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array]:
        return m.x - p[0], m.x + p[0]

    def distance_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials]:
        return Partials(x=1.0, theta=(-1.0,)), Partials(x=1.0, theta=(1.0,))

    def transform(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array, Array]:
        above, below = _outside(m)
        return np.asarray((m.x - p[0]) * above + (m.x + p[0]) * below), m.v * (above + below), m.s

    def transform_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials, Partials]:
        above, below = _outside(m)
        touching = above + below
        return Partials(x=touching, theta=(below - above,)), Partials(v=touching, theta=(0.0,)), _SAME


_SAME = Partials(s=1.0, theta=(0.0,))


def _outside(m: Motion) -> tuple[Array, Array]:
    """One where the twist is above the gap, and where it is below, else zero, (n,) each."""
    return (1.0 + m.side[0]) / 2.0, (1.0 - m.side[1]) / 2.0
