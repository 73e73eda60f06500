"""The mechanics of an inertia that hangs on a port by a spring and a damper."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.term import Motion, Oscillation, Partials, Role, Term


class HungMass(Term):
    """An inertia behind an elastic link.

    Its parameters are, in this order, the inertia J, and the frequency w [rad/s] and damping ratio of its oscillation
    with the port locked, so that spring and damper vanish with J. States are the twist of the link and the speed of the
    inertia.
    """

    states = ("twist", "speed")
    linear = True
    role = Role.MASS

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(p[0] * self.rate(m, p)[1])

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        J, _, tool = p[0], *self.rate_partials(m, p)
        return Partials(
            v=J * tool.v,
            z=tuple(J * d for d in tool.z),
            theta=(self.rate(m, p)[1], *(J * d for d in tool.theta[1:])),
        )

    def rate(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array]:
        _, w, zeta = p
        slip = m.v - m.z[1]
        return slip, np.asarray(w**2 * m.z[0] + 2.0 * zeta * w * slip)

    def rate_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials]:
        _, w, zeta = p
        slip = m.v - m.z[1]
        d = 2.0 * zeta * w
        link = Partials(v=1.0, z=(0.0, -1.0), theta=(0.0, 0.0, 0.0))
        tool = Partials(v=d, z=(w**2, -d), theta=(0.0, 2.0 * w * m.z[0] + 2.0 * zeta * slip, 2.0 * w * slip))
        return link, tool

    def settled(self, m: Motion, p: Sequence[float]) -> tuple[Array | float, ...]:
        return (0.0, m.v)

    def sized(self, oscillation: Oscillation) -> tuple[float, float, float]:
        return oscillation.inertia, oscillation.frequency, oscillation.damping_ratio
