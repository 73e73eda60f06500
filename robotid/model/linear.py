"""A joint linearised at an operating point: the same partials as the equations of motion, read as matrices.

Dry friction is constant while the direction of motion lasts, and a cubic spring has no slope where it is untwisted:
both drop out by themselves, as in Figure 3 of the paper.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, Complex
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.model.port import Signal

FADED = 4096  # samples after which the response of a channel has faded


@dataclass(frozen=True, slots=True, eq=False)
class LinearJoint:
    """M ddq + D dq + K q = B u at an operating point, and the same with all states, dx/dt = A x + b u.

    K, D, M : (nv, nv) over the angles (phi_m, phi_a, phi_b), memory of the terms fixed; A (nx, nx), b (nx,) over the
    joint's states; motor : row of the motor speed.
    """

    K: Array
    D: Array
    M: Array
    A: Array
    b: Array
    motor: int

    def speed_response(self, omega: Array) -> Complex:
        """From motor torque to motor speed [rad/s/Nm]. omega (n,) [rad/s] -> (n,); nan where masses are bound more
        stiffly than floating point can tell."""
        s = 1j * np.asarray(omega)[:, None, None]
        torque = np.broadcast_to(self.b[:, None], (len(s), len(self.b), 1))
        try:
            return np.asarray(np.linalg.solve(s * np.eye(len(self.b)) - self.A, torque)[:, self.motor, 0])
        except np.linalg.LinAlgError:
            return np.full(len(s), np.nan + 0j)

    def response(self, omega: Array) -> Complex:
        """From motor torque to motor acceleration [rad/s2/Nm]. omega (n,) [rad/s] -> (n,)."""
        return np.asarray(1j * np.asarray(omega) * self.speed_response(omega))


def linearise(joint: Joint, theta: Array, speed: float = 0.0) -> LinearJoint:
    """The joint about a steady motor speed [rad/s], at angle zero, untwisted, all masses moving together.

    At rest the joint is about to move forwards: friction slips. Companions are at their means. theta : (p,) in the
    order of joint.names.
    """
    joint, x, zero = joint.at_mean_companions(), np.zeros((joint.nx, 1)), np.zeros(1)
    x[joint.speeds, 0] = speed * np.array([1.0, joint.ratio, joint.ratio])[: joint.masses]
    s = np.full((joint.masses, 1), 1.0 if speed >= 0 else -1.0)
    x = joint.settled(x, s, zero, theta)
    slopes, mass = joint.slopes(x, s, zero, theta)
    K, D = -slopes[:, : joint.speeds.start, 0] @ joint.positions, -slopes[:, joint.speeds, 0]
    point = joint.evaluate(x, zero, s, zero, theta, columns=DerivativeColumns())
    assert point.B is not None
    return LinearJoint(K, D, mass[..., 0], point.A[..., 0], point.B[:, -1, 0], joint.speeds.start)


def channel_response(joint: Joint, theta: Array, omega: Array, sampling_time: float) -> Complex:
    """What the channels on torque and speed make of small signals, (n,): the transform of their impulse response."""
    impulse = np.zeros(FADED)
    impulse[1] = 1.0  # not the first: a channel takes that for what was before the record
    t, quiet = np.arange(-1, FADED - 1) * sampling_time, np.zeros(FADED)
    response = np.ones(len(omega), dtype=np.complex128)
    for _, channel, p, _ in joint.channels_on(theta, Signal.TORQUE, Signal.SPEED):
        after = channel.push(impulse, quiet, sampling_time, p)
        with_duration = np.flatnonzero(after)
        response *= np.exp(-1j * np.outer(omega, t[with_duration])) @ after[with_duration]
    return response
