"""Friction that is elastic before it slips."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Motion, MotionTransform, Partials


class Presliding(MotionTransform):
    """Bristles between the surfaces carry the friction: they bend before they slip, and spring back at reversals.

    One state, the deflection z in parts of that at which bristles slip, takes the place of sgn(v) in all friction at
    the port. Dahl's law for s1 = 0. Shows itself as hysteresis around reversals.
    """

    name = "presliding"
    ports = (Port.MOTOR, Port.ARM)
    parameters = (
        Parameter("w", "1", "share of the friction that bristles carry", guess=1.0, bounds=(0.0, 1.0), null=0.0),
        Parameter(
            "s0",
            "1/rad",
            "stiffness of the bristles per friction",
            guess=100.0,
            bounds=(0.01, 1e5),
            grid=(3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0),
            physical=Physical("the bristles would hardly slip", bends=3.0),
        ),
        # No negative damping; zero is Dahl's law, and as good as any to search for bristles with.
        Parameter("s1", "s", "damping of the bristles per stiffness", guess=1e-3, bounds=(0.0, 10.0), grid=(0.0,)),
    )
    formula = "friction sees (1 - w) sgn(v) + w (z + s1 dz/dt), dz/dt = s0 (v - |v| z)"
    source = "Dahl 1968; Canudas de Wit, Olsson, Astrom & Lischinsky 1995, IEEE Trans. Automatic Control 40(3)"
    signature = "hysteresis around reversals"
    states = ("z",)
    state_limit = 1.0

    def transform(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array, Array]:
        w, _, s1 = p
        return m.x, m.v, np.asarray(m.s + w * (m.z[0] + s1 * self.rate(m, p)[0] - m.s))

    def transform_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials, Partials]:
        w, _, s1 = p
        (rate,), (d,) = self.rate(m, p), self.rate_partials(m, p)
        carried = Partials(
            v=w * s1 * d.v,
            s=1.0 - w + w * s1 * d.s,
            z=(w + w * s1 * d.z[0],),
            theta=(m.z[0] + s1 * rate - m.s, w * s1 * d.theta[1], w * rate),
        )
        z, theta = (0.0,), (0.0, 0.0, 0.0)
        return Partials(x=1.0, z=z, theta=theta), Partials(v=1.0, z=z, theta=theta), carried

    def rate(self, m: Motion, p: Sequence[float]) -> tuple[Array]:
        return (np.asarray(p[1] * m.v * (1.0 - m.z[0] * m.s)),)

    def rate_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials]:
        left = 1.0 - m.z[0] * m.s
        return (
            Partials(
                v=p[1] * left,
                s=-p[1] * m.v * m.z[0],
                z=(-p[1] * m.v * m.s,),
                theta=(0.0, m.v * left, 0.0),
            ),
        )

    def settled(self, m: Motion, p: Sequence[float]) -> tuple[Array]:
        return (m.s,)
