"""The drive's controller: a sampled cascade of position and speed loop, its torque constant from sample to sample."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from robotid.model.array import Array


@dataclass(frozen=True, slots=True)
class Controller:
    """u = clip(kp e + ki I + feedforward dref/dt, limit), dI/dt = e.

    kind "speed":    e = ref - dphi_m.                    kp [Nm s/rad], ki [Nm/rad], limit [Nm]
    kind "position": e = kpos (ref - phi_m) - dphi_m.     kpos [1/s]
    feedforward [kg m2] is applied to the reference's derivative (speed control only). The integral stops while the
    torque saturates.
    """

    kind: str
    kp: float
    ki: float = 0.0
    kpos: float = 0.0
    feedforward: float = 0.0
    limit: float = inf

    def error(self, ref: Array, phi_m: Array, dphi_m: Array) -> Array:
        """Speed error e, (n,)."""
        return np.asarray((self.kpos * (ref - phi_m) if self.kind == "position" else ref) - dphi_m)

    def torque(self, error: Array, integral: Array, dref: Array) -> tuple[Array, Array]:
        """Torque (n,), and where it is not saturated (n,) as 1.0 or 0.0."""
        wanted = self.kp * error + self.ki * integral
        if self.kind == "speed":
            wanted = wanted + self.feedforward * dref
        return np.clip(wanted, -self.limit, self.limit), (np.abs(wanted) < self.limit).astype(np.float64)
