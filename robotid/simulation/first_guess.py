"""A trajectory near the one sought, made of the measured motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.record import Record
from robotid.simulation.friction.step import Steps
from robotid.simulation.newton.problem import Problem
from robotid.simulation.newton.solver import Course, followed, integrating

MAD_OF_NORMAL = 0.6745  # median absolute deviation of a normal variable, in standard deviations
REST = 3.0  # standard deviations of the speed's noise below which a speed counts as rest


def initial_state(joint: Joint, theta: Array, record: Record) -> Array:
    """First state as measured, the arm moving rigidly with the motor and the gear untwisted, (nx,)."""
    return _as_measured(joint, joint.in_record(theta, record.name), record, slice(0, 1))[:, 0]


def measured_guess(joint: Joint, theta: Array, record: Record) -> Array:
    """The measured motion as states, arm and tool rigid, memory settled, (nx, n).

    A speed lost in its own noise counts as rest: where friction makes the motor stick, noise would look like a host of
    reversals.
    """
    return _as_measured(joint, theta, record, slice(None))


def _as_measured(joint: Joint, theta: Array, record: Record, at: slice) -> Array:
    """These samples of `measured_guess`."""
    joint, speed = joint.along(record), record.dphi_m[at]
    if joint.dry:
        noise = np.median(np.abs(np.diff(record.dphi_m, 2))) / (MAD_OF_NORMAL * np.sqrt(6.0))
        speed = np.where(np.abs(speed) > REST * noise, speed, 0.0)
    x = np.zeros((joint.nx, len(speed)))
    if joint.keeps_angle:
        x[joint.motor_angle] = record.phi_m[at]
    x[joint.motor_speed] = speed
    x[joint.motor_speed + 1 : joint.speeds.stop] = joint.ratio * speed
    return joint.settled(x, np.sign(x[joint.speeds]), record.t[at], theta)


@dataclass(frozen=True, slots=True, eq=False)
class PrescribedMotor(Problem):
    """The motor moves as guessed, and drives all other states."""

    tolerance: ClassVar[float] = 1e-2  # a guess need not be better

    def moving(self, steps: Steps) -> Steps:
        return steps.with_prescribed(self.joint.motor_states)


def follow_motor(problem: Problem, x0: Array) -> Array:
    """What `following_motor` leads to."""
    return followed(following_motor(problem, x0))


def following_motor(problem: Problem, x0: Array) -> Course[Array]:
    """The problem's guess with all states but the motor's as its motion drives them from x0 (nx,), (nx, n).

    Whether a motor near rest sticks depends on the forces, so the gear's torque must be about right. Where that motion
    diverges, the guess stays as it is.
    """
    joint, guess = problem.joint, problem.guess
    if joint.nx == 1 + joint.keeps_angle:
        return guess
    prescribed = PrescribedMotor(
        joint,
        problem.theta,
        problem.u,
        problem.sampling_time,
        guess,
        begin=problem.begin,
        torque_steps=problem.torque_steps,
    )

    def as_guessed(first: int, stop: int, start: Array) -> Array:
        return np.asarray(np.concatenate([start[:, None], guess[:, first + 1 : stop + 1]], axis=1))

    try:
        return (yield from integrating(prescribed, x0, as_guessed))[0]
    except NumericsError:
        return guess
