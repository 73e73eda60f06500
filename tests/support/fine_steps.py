"""The paper's joint with effects that are hard to simulate, by small steps in plain floats: no code of robotid's.

Semi-implicit time stepping (Moreau 1988): in every substep dry friction first takes what it needs to bring the motor to
rest, at most its level. First order in the substep, whatever kinks and jumps there are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, exp, sin

import numpy as np

from robotid.model.array import Array
from support.paper_joint import RATIO, TRUTH


@dataclass(frozen=True)
class Hidden:
    """Effects on top of the paper's joint, each absent at zero."""

    gap: float = 0.0
    soft: float = 0.0
    soft_within: float = 1e-4
    error: float = 0.0
    error_periods: float = 2.0
    load: float = 0.0
    warm_up: float = 0.0
    warm_up_time: float = 1.0
    bristles: float = 0.0
    bristle_damping: float = 0.0
    slip_torque: float = 0.0
    slip_twist: float = 1e-4


def fine_steps(u: Array, h: float, hidden: Hidden, substeps: int = 50) -> Array:
    """Motor speed under held torque u, from rest, (n,)."""
    jm, fv, fc, _, _, _, ja = (TRUTH[k] for k in TRUTH)
    dt, r = h / substeps, RATIO
    gear = _gear(hidden)
    twist = wm = wa = phi = z = bristle = t = 0.0
    out = np.empty(len(u))
    for n, torque in enumerate(u.tolist()):
        out[n] = wm
        for _ in range(substeps):
            slip = r * wm - wa
            felt, lever = gear(twist + 0.5 * dt * slip, slip, phi, wm)
            felt += hidden.slip_torque * z
            z += dt * (slip - abs(slip) * abs(z) * z) / hidden.slip_twist
            fade = 1.0 + hidden.warm_up * exp(-t / hidden.warm_up_time)
            drive = torque - fv * fade * wm - lever * felt
            level = fc * fade + hidden.load * abs(r * felt)
            before = wm
            if hidden.bristles:
                # The law of the bristle is linear in its deflection: one implicit step each, as it is stiff.
                free = wm + dt * drive / jm
                stretched = (bristle + dt * hidden.bristles * free) / (1.0 + dt * hidden.bristles * abs(free))
                rate = (stretched - bristle) / dt
                wm = free - dt * level * (stretched + hidden.bristle_damping * rate) / jm
                bristle = stretched
            else:
                free, most = wm + dt * drive / jm, dt * level / jm
                wm = 0.0 if abs(free) <= most else free - most if free > 0 else free + most
            wa += dt * felt / ja
            twist += 0.5 * dt * (slip + r * wm - wa)
            phi += 0.5 * dt * (before + wm)
            t += dt
    return out


def _gear(hidden: Hidden) -> Callable[[float, float, float, float], tuple[float, float]]:
    """Torque of spring and damper, and its lever on the motor, at twist, slip, motor angle and motor speed."""
    k1, k3, d = (TRUTH[f"gear.{name}"] for name in ("spring.k1", "cubic_spring.k3", "damper.d"))
    gap, soft, xs, n = hidden.gap, hidden.soft, hidden.soft_within, hidden.error_periods

    def torque(twist: float, slip: float, phi: float, wm: float) -> tuple[float, float]:
        lever = RATIO
        if hidden.error:
            turn = hidden.error * n * cos(n * phi)
            twist, slip, lever = twist + hidden.error * sin(n * phi), slip + turn * wm, RATIO + turn
        if gap:
            if abs(twist) <= gap:
                return 0.0, lever
            twist -= gap if twist > 0 else -gap
        x = twist - soft * max(-xs, min(xs, twist)) if soft else twist
        return k1 * x + k3 * x * x * x + d * slip, lever

    return torque
