"""Open-loop simulation: a joint driven by a recorded torque."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from robotid.errors import NumericsError
from robotid.model.array import Array, blocks
from robotid.model.joint import Joint
from robotid.signals.record import Record
from robotid.simulation.actuator import ActingTorque, acting_torque
from robotid.simulation.fallback.lsoda import lsoda
from robotid.simulation.first_guess import following_motor, initial_state, measured_guess
from robotid.simulation.in_turns import InTurns, beside_all
from robotid.simulation.newton.problem import FIRST_WINDOW, NEAR_WINDOW, Problem
from robotid.simulation.newton.solver import Course, followed, integrating, state_scale
from robotid.simulation.newton.together import followed_together
from robotid.simulation.trajectory import Trajectory

PATIENCE_SAMPLES = 4000  # to which a number of windows that may fail belongs
TOGETHER = 200_000  # samples of all records: longer ones go one by one, for less memory
MAX_GUESS = 100.0  # times the motion itself: beside a guess so large, what is not small passes for small


def simulate(
    joint: Joint,
    theta: Array,
    record: Record,
    x0: Array | None = None,
    guess: Array | None = None,
    max_failed_windows: int | None = None,
) -> Trajectory:
    """Open-loop response of a joint to a record's torque.

    theta : (p,) in the order of joint.names, its changes those of records by their names; x0 : (nx,) first state, by
    default `initial_state`; guess : (nx, n) a trajectory nearby, by default the measured motion; max_failed_windows :
    how many windows may fail to settle in PATIENCE_SAMPLES samples, by default any number. Raises NumericsError where
    even LSODA diverges, where x0 is not finite, and where more windows fail.
    """
    return followed(_simulating(joint, theta, record, Start(x0, guess), max_failed_windows))


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where a simulation starts. x0 : (nx,) first state; guess : (nx, n) a trajectory nearby; each None as of
    `simulate`."""

    x0: Array | None = None
    guess: Array | None = None


def simulate_together(
    joint: Joint,
    theta: Array,
    records: Sequence[Record],
    starts: Sequence[Start],
    max_failed_windows: int | None = None,
) -> Iterator[Trajectory]:
    """The open-loop response to each record's torque, all at once where the records share parameters.

    Arguments and errors as of `simulate`, a start for each record.
    """
    alike = joint.is_one_in(record.name for record in records)
    few = len(records) > 1 and alike and sum(map(len, records)) <= TOGETHER
    every = beside_all([joint.along(record) for record in records]) if few else None
    courses = (
        _simulating(joint, theta, record, start, max_failed_windows, every, k)
        for k, (record, start) in enumerate(zip(records, starts, strict=True))
    )
    return map(followed, courses) if every is None else iter(followed_together(list(courses)))


def simulate_under(
    torques: Sequence[Array],
    joint: Joint,
    theta: Array,
    record: Record,
    start: Start,
    max_failed_windows: int | None = None,
) -> Iterator[Trajectory | None]:
    """The open-loop response to each of several torques (n,), as many at once as `simulate_together` takes, beside all
    else that a record holds; None where there is none. The other arguments as of `simulate`. Raises NumericsError where
    the joint has no mass in a pose that one of them leads to."""

    def course(torque: Array) -> Course[Trajectory | None]:
        try:
            return (yield from _simulating(joint, theta, replace(record, tau_m=torque), start, max_failed_windows))
        except NumericsError:
            return None

    for at in blocks(len(torques), max(1, TOGETHER // len(record))):
        yield from followed_together([course(torque) for torque in torques[at]])


def _simulating(
    joint: Joint,
    theta: Array,
    record: Record,
    start: Start,
    max_failed_windows: int | None,
    every: InTurns | None = None,
    k: int = 0,
) -> Course[Trajectory]:
    """The course of `simulate`. every : the joint beside this record, number k, and others."""
    joint, theta = joint.along(record), joint.in_record(theta, record.name)
    x0 = initial_state(joint, theta, record) if start.x0 is None else start.x0
    torque = acting_torque(joint, theta, record)
    if not np.isfinite(x0).all():
        raise NumericsError("the first state is not finite", hint="check the parameters' guesses and bounds")
    share = max(1.0, len(record) / PATIENCE_SAMPLES)
    known = start.guess is not None and np.isfinite(start.guess).all()
    problem = Problem(
        joint if every is None else every.joint,
        theta,
        torque.mean[:-1],
        record.sampling_time,
        start.guess if known and start.guess is not None else measured_guess(joint, theta, record),
        begin=record.begin if every is None else every.begin(k, record.begin),
        torque_steps=torque.steps,
        max_failed_windows=None if max_failed_windows is None else round(max_failed_windows * share),
        first_window=NEAR_WINDOW if known else FIRST_WINDOW,
    )
    if not known:
        problem = replace(problem, guess=(yield from following_motor(problem, x0)))
    alone = replace(problem, joint=joint, begin=record.begin)
    x, failed, fallback_windows = yield from _integrating(problem, x0, alone)
    if np.any(state_scale(problem.guess) > MAX_GUESS * state_scale(x)):
        x, failed, fallback_windows = yield from _integrating(replace(problem, guess=x), x0, alone)
    found = trajectory_of(alone, torque, record, x)
    return replace(found, fallback_windows=fallback_windows, failed_windows=ceil(failed / share))


def trajectory_of(problem: Problem, torque: ActingTorque, record: Record, x: Array) -> Trajectory:
    """The trajectory of a record that states x (nx, n) make under the torque that acts."""
    joint, theta = problem.joint, problem.theta
    dphi = x[joint.motor_speed]
    phi = x[joint.motor_angle] if joint.keeps_angle else record.phi_m[0] + integrated(dphi, record.sampling_time)
    return Trajectory(
        joint,
        theta,
        record.sampling_time,
        torque.mean,
        x,
        phi_m=phi,
        dphi_m=dphi,
        twist=x[0] if joint.masses > 1 else None,
        begin=record.begin,
        speed_origin=record.speed_origin,
        torque_steps=torque.steps,
    )


def integrated(speed: Array, sampling_time: float) -> Array:
    """The angle that a speed travels from zero, by trapezoids. (..., n) -> (..., n)."""
    step = sampling_time / 2 * (speed[..., 1:] + speed[..., :-1])
    return np.concatenate([np.zeros_like(speed[..., :1]), np.cumsum(step, axis=-1)], axis=-1)


def _integrating(problem: Problem, x0: Array, alone: Problem) -> Course[tuple[Array, int, tuple[tuple[int, int], ...]]]:
    """All nodes (nx, n), the least max_failed_windows that allows them, and the windows that LSODA integrated. alone :
    the problem beside its own record."""
    windows: list[tuple[int, int]] = []

    def fallback(first: int, stop: int, start: Array) -> Array:
        windows.append((first, stop))
        return lsoda(alone, first, stop, start)

    x, failed = yield from integrating(problem, x0, fallback)
    return x, failed, tuple(windows)
