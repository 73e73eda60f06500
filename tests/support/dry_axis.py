"""A rigid axis with viscous and dry friction under a held torque, integrated exactly from event to event."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array


@dataclass(frozen=True, slots=True)
class DryAxis:
    """J dw/dt = u - Fv w - Fc sgn(w) [SI]."""

    J: float = 0.01
    Fv: float = 0.05
    Fc: float = 0.5

    def motion(self, stamps: Array, torque: Array, at: Array) -> tuple[Array, Array]:
        """Speed and angle at increasing times at (m,), none before the first stamp, from rest under a torque (n,) that
        lasts from its stamp to the next, (m,) each."""
        edges = np.union1d(stamps, at)
        u = torque[np.searchsorted(stamps, edges, side="right") - 1]
        speed, angle = np.zeros((2, len(edges)))
        for k, step in enumerate(np.diff(edges)):
            speed[k + 1], moved = self._held(float(speed[k]), float(u[k]), float(step))
            angle[k + 1] = angle[k] + moved
        seen = np.searchsorted(edges, at)
        return speed[seen], angle[seen]

    def _held(self, speed: float, u: float, left: float) -> tuple[float, float]:
        """Speed after a time under a torque, and the angle moved."""
        moved, tau = 0.0, self.J / self.Fv
        while left > 0.0:
            if speed == 0.0 and abs(u) <= self.Fc:
                break
            final = (u - self.Fc * float(np.sign(speed or u))) / self.Fv
            rest = tau * float(np.log1p(-speed / final)) if final * speed < 0.0 else np.inf
            step = min(rest, left)
            decay = float(np.exp(-step / tau))
            moved += final * step + (speed - final) * tau * (1.0 - decay)
            speed = 0.0 if rest <= left else final + (speed - final) * decay
            left -= step
        return speed, moved


def switched_torque(t: Array) -> Array:
    """A torque [Nm] that changes in large steps, with two slower waves in it; four reversals a second of `DryAxis`."""
    waves = 0.7 * np.sin(2 * np.pi * 0.9 * t + 0.4) + 0.5 * np.sin(2 * np.pi * 7.3 * t)
    return np.asarray(2.0 * np.sign(np.sin(4 * np.pi * t)) + waves)
