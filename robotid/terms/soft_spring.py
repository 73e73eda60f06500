"""A spring that is soft at small twist."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Extreme, Motion, MotionTransform, Partials


class SoftSpring(MotionTransform):
    """Lost motion and wind-up: within a small twist the springs have a share less of their stiffness.

    Shows itself as a resonance that falls at small amplitude.
    """

    name = "soft_spring"
    ports = (Port.GEAR, Port.LINK)
    parameters = (
        # Not zero: there the fit could not see xs.
        Parameter("s", "1", "share of the stiffness that small twist lacks", guess=0.1, bounds=(0.0, 1.0), null=0.0),
        Parameter(
            "xs",
            "rad",
            "twist beyond which it is stiff",
            guess=1e-4,
            bounds=(1e-7, 1.0),
            grid=(1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3),
            physical=Physical("the gear never twists so far", within_travel=True),
        ),
    )
    formula = "springs see x - s clip(x, -xs, xs)"
    source = "ISO 9283 and makers' hysteresis curves (lost motion); Taghirad & Belanger 1998, J. Dynamic Systems 120(1)"
    signature = "a resonance that falls at small amplitude"
    edges = ("upper", "lower")
    extremes = (Extreme("s", "backlash", {"gap": ("s", "xs")}),)

    def distance(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array]:
        return m.x - p[1], m.x + p[1]

    def distance_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials]:
        return Partials(x=1.0, theta=(0.0, -1.0)), Partials(x=1.0, theta=(0.0, 1.0))

    def transform(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array, Array]:
        inside, way = _region(m)
        return np.asarray(m.x - p[0] * (inside * m.x + way * p[1])), m.v, m.s

    def transform_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials, Partials]:
        s, xs = p
        inside, way = _region(m)
        clipped = inside * m.x + way * xs
        none = (0.0, 0.0)
        return (
            Partials(x=1.0 - s * inside, theta=(-clipped, -s * way)),
            Partials(v=1.0, theta=none),
            Partials(s=1.0, theta=none),
        )


def _region(m: Motion) -> tuple[Array, Array]:
    """One while the twist is small, else zero; and the side it is on beyond, else zero, (n,) each."""
    return (m.side[1] - m.side[0]) / 2.0, (m.side[0] + m.side[1]) / 2.0
