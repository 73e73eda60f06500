"""The torque that a model needs for the motion that was measured, beside the torque that was applied.

The motor moves as measured and drives the rest of the joint, which is simulated: above the notch the arm hardly
follows, and a rigid prediction would be wrong by far. For a rigid axis this is step 1's regression with the model's
values.
"""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array, blocks
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.signals.differentiate import AUTOMATIC, Kinematics, ParallelFilter, bandwidth
from robotid.signals.metrics import error_percent
from robotid.signals.record import Record
from robotid.simulation.actuator import effective_torque
from robotid.simulation.first_guess import follow_motor, measured_guess
from robotid.simulation.newton.problem import Problem
from robotid.simulation.trajectory import BLOCK

SWEEPS = 4  # each leaves about a tenth of the error


def torque_error(
    joint: Joint,
    theta: Array,
    record: Record,
    first_state: Array,
    parallel: ParallelFilter = AUTOMATIC,
) -> float | None:
    """100 ||tau - tau_hat|| / ||tau|| [%], both through the same zero-phase filter; None for a constant torque.

    first_state : (nx,) of which the motor's part is overruled by the measurement. parallel : without a cut-off, 99 %
    of the torque's energy lies below the one that it gets.
    """
    h, joint = record.sampling_time, joint.along(record)
    parallel = parallel.at(bandwidth(record.tau_m, h) if np.ptp(record.tau_m) > 0 else 0.0)
    if not parallel.cutoff:
        return None
    motion = parallel.motion(record.phi_m, h)
    needed = required_torque(joint, theta, record, motion, first_state)
    # Between samples the torque is constant: at a sample it is, on average, the mean of what was before and what comes.
    torque = effective_torque(joint, theta, h, record.tau_m)
    applied = (torque + np.concatenate([torque[:1], torque[:-1]])) / 2
    tau, tau_hat, speed = (parallel.apply(signal, h) for signal in (applied, needed, motion.speed))
    kept = np.abs(speed) >= parallel.min_speed
    return error_percent(tau[kept], tau_hat[kept]) if kept.any() else None


def required_torque(joint: Joint, theta: Array, record: Record, motion: Kinematics, first_state: Array) -> Array:
    """Motor torque of the model under a motion of the motor, (n,) [Nm]. first_state : (nx,), of the other states."""
    joint = joint.along(record)
    x = measured_guess(joint, theta, record)
    prescribed = {joint.motor_speed: motion.speed}
    if joint.keeps_angle:
        prescribed[joint.motor_angle] = motion.position
    for row, signal in prescribed.items():
        x[row] = signal
    torque = _balance(joint, theta, x, motion.acceleration, record.t)
    if joint.nx == len(prescribed):
        return torque
    start = first_state.copy()
    start[list(prescribed)] = x[list(prescribed), 0]
    for _ in range(SWEEPS):
        x = follow_motor(Problem(joint, theta, torque[:-1], record.sampling_time, x, begin=record.begin), start)
        torque = _balance(joint, theta, x, motion.acceleration, record.t)
    return torque


def _balance(joint: Joint, theta: Array, x: Array, acceleration: Array, t: Array) -> Array:
    """The torque that gives the motor this acceleration in states x (nx, n): acceleration is affine in it."""
    torque, motor = np.empty(x.shape[1]), joint.motor_speed
    for at in blocks(len(torque), BLOCK):
        still = np.zeros(len(t[at]))
        free = joint.evaluate(x[:, at], still, np.sign(x[joint.speeds, at]), t[at], theta, columns=DerivativeColumns())
        assert free.B is not None
        torque[at] = (acceleration[at] - free.f[motor]) / free.B[motor, -1]
    return torque
