"""Two links in a vertical plane by Lagrange's equations, written out, without any code of `robotid.body`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array

GRAVITY = 9.81


@dataclass(frozen=True, slots=True)
class Link:
    """mass [kg], distance of its centre from its axis [m], inertia about the centre [kg m2]."""

    mass: float
    centre: float
    inertia: float


UPPER, LOWER = Link(8.0, 0.21, 0.3), Link(5.0, 0.17, 0.11)
LENGTH = 0.5  # [m] from the first axis to the second
VISCOUS, DRY, ROTORS = np.array([4.0, 2.0]), np.array([3.0, 1.5]), np.array([0.9, 0.4])


def mass_matrix(q: Array) -> Array:
    """(2, 2, n) of angles (2, n), each counted from the link before it."""
    c = np.cos(q[1])
    own = LOWER.inertia + LOWER.mass * LOWER.centre**2
    mixed = own + LOWER.mass * LENGTH * LOWER.centre * c
    first = (
        UPPER.inertia + UPPER.mass * UPPER.centre**2 + own + LOWER.mass * (LENGTH**2 + 2 * LENGTH * LOWER.centre * c)
    )
    return np.array([[first, mixed], [mixed, np.full_like(c, own)]])


def body_torque(q: Array, dq: Array, ddq: Array) -> Array:
    """Torques (2, n) [Nm] that move the links: both turn about horizontal axes, up at a quarter turn."""
    s = LOWER.mass * LENGTH * LOWER.centre * np.sin(q[1])
    velocity = np.array([-s * (2 * dq[0] * dq[1] + dq[1] ** 2), s * dq[0] ** 2])
    tip = LOWER.mass * GRAVITY * LOWER.centre * np.cos(q[0] + q[1])
    weight = np.array([(UPPER.mass * UPPER.centre + LOWER.mass * LENGTH) * GRAVITY * np.cos(q[0]) + tip, tip])
    return np.einsum("ijn,jn->in", mass_matrix(q), ddq) + velocity + weight


def torque(q: Array, dq: Array, ddq: Array) -> Array:
    """The same with rotors and friction."""
    return body_torque(q, dq, ddq) + ROTORS[:, None] * ddq + VISCOUS[:, None] * dq + DRY[:, None] * np.sign(dq)


def swing(seed: int, t: Array, size: float = 1.0) -> tuple[Array, Array, Array]:
    """Angles, speeds and accelerations (2, n) of a sum of waves."""
    rng = np.random.default_rng(seed)
    w = 2 * np.pi * rng.uniform(0.1, 0.6, (2, 4))[..., None]
    phase, amplitude = rng.uniform(0, 2 * np.pi, (2, 4, 1)), size * rng.uniform(0.1, 0.4, (2, 4, 1))
    turned = w * t + phase
    q, dq = (amplitude * np.sin(turned)).sum(1), (amplitude * w * np.cos(turned)).sum(1)
    return q, dq, -(amplitude * w**2 * np.sin(turned)).sum(1)
