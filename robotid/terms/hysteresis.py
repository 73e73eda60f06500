"""Hysteresis of a gear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class Hysteresis(Term):
    """Friction between teeth and rollers, as a spring that slips: Bouc-Wen with one state z in [-1, 1].

    Shows itself as gear torque that depends on the direction of twist.
    """

    name = "hysteresis"
    ports = (Port.GEAR, Port.LINK)
    parameters = (
        # Not zero: there the fit could not see xs.
        Parameter("kh", "Nm", "torque at which it slips", guess=10.0, bounds=(-1e9, 1e9), null=0.0),
        Parameter(
            "xs",
            "rad",
            "twist to slip",
            guess=1e-4,
            bounds=(1e-7, 1.0),
            grid=(1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3),
            physical=Physical("the gear never twists so far", within_travel=True),
        ),
    )
    formula = "kh z, dz/dt = (v - |v| |z| z) / xs"
    source = (
        "Wen 1976, J. Engineering Mechanics 102(2); Ruderman, Hoffmann & Bertram 2009, IEEE Trans. Ind. Electronics"
    )
    signature = "gear torque that depends on the direction of twist"
    friction = True
    states = ("z",)
    state_limit = 1.0

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(p[0] * m.z[0])

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(z=(p[0],), theta=(m.z[0], 0.0))

    def rate(self, m: Motion, p: Sequence[float]) -> tuple[Array]:
        z = m.z[0]
        return ((m.v - m.v * m.s * z * z * np.sign(z.real)) / p[1],)

    def rate_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials]:
        z, way = m.z[0], np.sign(m.z[0].real)
        flow = m.v - m.v * m.s * z * z * way
        return (
            Partials(
                v=(1.0 - m.s * z * z * way) / p[1],
                s=-m.v * z * z * way / p[1],
                z=(-2.0 * m.v * m.s * z * way / p[1],),
                theta=(0.0, -flow / p[1] ** 2),
            ),
        )
