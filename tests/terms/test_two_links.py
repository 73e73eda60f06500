"""Coupling and pose against two links in a plane, whose torques follow from their kinetic energy by differences."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.array import Array
from robotid.model.term import Motion
from robotid.terms import TERMS

M1, L1, C1, I1 = 3.0, 0.7, 0.3, 0.2
M2, C2, I2 = 2.0, 0.4, 0.1
LEVER, FAR, BEHIND = M2 * L1 * C2, I2 + M2 * C2**2, 0.6
"""Of the coupling: varying and constant part [kg m2]. BEHIND : what the second link's zero is off by [rad]."""

H = 1e-3


def angles(t: Array) -> Array:
    """Both joints (2, n) [rad], the second from the direction of the first."""
    return np.array([0.8 * np.sin(1.7 * t) + 0.3 * t, 1.1 * np.cos(2.3 * t) - 0.5 * t])


def energy(q: Array, dq: Array) -> Array:
    """Kinetic energy [J] (n,), from the speeds of the centres of mass."""
    far, spin = q[0] + q[1], dq[0] + dq[1]
    x = -L1 * np.sin(q[0]) * dq[0] - C2 * np.sin(far) * spin
    y = L1 * np.cos(q[0]) * dq[0] + C2 * np.cos(far) * spin
    return np.asarray(0.5 * ((M1 * C1**2 + I1) * dq[0] ** 2 + M2 * (x**2 + y**2) + I2 * spin**2))


def lagrange(joint: int, t: Array) -> Array:
    """The torque of one joint [Nm] (n,): d/dt dT/d(dq) - dT/dq, by central differences."""
    step = np.zeros((2, 1))
    step[joint] = H

    def momentum(at: Array) -> Array:
        q, dq, _ = moved(at)
        return np.asarray((energy(q, dq + step) - energy(q, dq - step)) / (2 * H))

    q, dq, _ = moved(t)
    steepness = (energy(q + step, dq) - energy(q - step, dq)) / (2 * H)
    return np.asarray((momentum(t + H) - momentum(t - H)) / (2 * H) - steepness)


def moved(t: Array) -> tuple[Array, Array, Array]:
    """Angles, speeds and accelerations, (2, n) each."""
    q, before, after = angles(t), angles(t - H), angles(t + H)
    return q, (after - before) / (2 * H), (after - 2 * q + before) / H**2


def seen(joint: int, t: Array, offset: float = 0.0) -> Motion:
    """The motion of one joint beside the other. offset : of the second joint's angle [rad]."""
    q, dq, ddq = moved(t)
    q = q + np.array([[0.0], [offset]])
    other = 1 - joint
    zero = np.zeros((0, len(t)))
    s = np.sign(dq[joint])
    return Motion(q[joint], dq[joint], ddq[joint], s, t, zero, w=q[other], dw=dq[other], ddw=ddq[other])


@pytest.mark.parametrize("offset", [0.0, BEHIND])
def test_the_second_link_feels_the_first_through_its_own_angle(offset: float) -> None:
    t = np.linspace(0.0, 5.0, 401)
    m = seen(1, t, offset)
    wave = LEVER * np.sin(offset), LEVER * np.cos(offset)
    torque = FAR * m.a + TERMS["coupling"].torque(m, (FAR, *wave, 1.0))
    assert torque == pytest.approx(lagrange(1, t), abs=1e-4)


@pytest.mark.parametrize("offset", [0.0, BEHIND])
def test_the_first_link_feels_the_second_through_coupling_and_pose(offset: float) -> None:
    t = np.linspace(0.0, 5.0, 401)
    m = seen(0, t, offset)
    A, B = LEVER * np.sin(offset), LEVER * np.cos(offset)
    own = I1 + M1 * C1**2 + M2 * L1**2 + FAR
    pose = TERMS["pose_inertia"].torque(m, (2 * A, 2 * B, 1.0))
    torque = own * m.a + pose + TERMS["coupling"].torque(m, (FAR, A, B, 0.0))
    assert torque == pytest.approx(lagrange(0, t), abs=1e-4)
