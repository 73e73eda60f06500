"""Simulation of a joint driven by a recorded torque, and the derivatives of every state to every parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.port import Signal
from robotid.signals.record import Record
from robotid.simulate.fallback.lsoda import lsoda
from robotid.simulate.friction.steps import Steps, linearise, modes
from robotid.simulate.newton.solver import LARGEST_WINDOW, LEAST_SCALE, Problem, integrate, solve_block_bidiagonal

BLOCK = 4000  # intervals whose derivatives are in memory at once
WILD = 100.0  # times the motion itself: a guess so large that what counts as small beside it is not


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A simulated motion at the n samples of a record.

    x : (nx, n) states; phi_m, dphi_m : (n,) [rad, rad/s]; twist : (n,) of the gear [rad], None for a rigid joint;
    u : (n,) effective torque; rescued : windows (first, stop) that LSODA had to integrate; begin [s] : of the record.
    """

    joint: Joint
    theta: Array
    sampling_time: float
    u: Array
    x: Array
    phi_m: Array
    dphi_m: Array
    twist: Array | None
    rescued: tuple[tuple[int, int], ...] = ()
    begin: float = 0.0

    @property
    def t(self) -> Array:
        """Times of the samples [s], (n,)."""
        return np.asarray(self.begin + np.arange(len(self.u), dtype=np.float64) * self.sampling_time)

    @property
    def ddphi_m(self) -> Array:
        """Motor acceleration at the start of each interval [rad/s2], (n,)."""
        joint, n = self.joint, len(self.u)
        problem = Problem(joint, self.theta, self.u, self.sampling_time, self.x, begin=self.begin)
        blocks = []
        for first in range(0, n, BLOCK):
            motive = problem.motive(first, min(n, first + BLOCK))
            x = self.x[:, first : first + BLOCK]
            mode = modes(motive, x)
            blocks.append(
                joint.evaluate(x, motive.u, mode.s, motive.t, self.theta, mode.sticking).f[joint.speeds.start]
            )
        return np.concatenate(blocks)


def simulate(
    joint: Joint,
    theta: Array,
    record: Record,
    x0: Array | None = None,
    guess: Array | None = None,
    patience: int | None = None,
) -> Trajectory:
    """Open-loop response of a joint to a record's torque.

    theta : (p,) in the order of joint.names, its changes those of records by their names; x0 : (nx,) first state, by
    default `initial_state`; guess : (nx, n) a trajectory nearby, by default the measured motion. Raises NumericsError
    where even LSODA diverges, where x0 is not finite, and where more windows fail to settle than patience allows in
    LARGEST_WINDOW samples.
    """
    theta = joint.in_record(theta, record.name)
    x0 = initial_state(joint, theta, record) if x0 is None else x0
    u = effective_torque(joint, theta, record)
    if not np.isfinite(x0).all():
        raise NumericsError("the first state is not finite", hint="check the parameters' guesses and bounds")
    near = guess if guess is not None and np.isfinite(guess).all() else measured_guess(joint, theta, record)
    problem = Problem(joint, theta, u[:-1], record.sampling_time, near, begin=record.begin)
    if near is not guess:
        problem = replace(problem, guess=follow_motor(problem, x0))
    if patience is not None:
        problem.patience = round(patience * max(1.0, len(u) / LARGEST_WINDOW))
    x, rescued = _march(problem, x0)
    if np.any(problem.scale > WILD * np.maximum(np.abs(x).max(axis=1), LEAST_SCALE)):
        x, rescued = _march(replace(problem, guess=x), x0)
    return _finish(problem, u, record, x, rescued)


def _march(problem: Problem, x0: Array) -> tuple[Array, tuple[tuple[int, int], ...]]:
    rescued: list[tuple[int, int]] = []

    def rescue(problem: Problem, first: int, stop: int, start: Array) -> Array:
        rescued.append((first, stop))
        return lsoda(problem, first, stop, start)

    return integrate(problem, x0, rescue), tuple(rescued)


def _finish(problem: Problem, u: Array, record: Record, x: Array, rescued: tuple[tuple[int, int], ...]) -> Trajectory:
    joint, h = problem.joint, problem.sampling_time
    dphi = x[joint.speeds.start]
    if joint.keeps_angle:
        phi = x[joint.speeds.start - 1]
    else:
        phi = record.phi_m[0] + np.concatenate([[0.0], np.cumsum(h / 2 * (dphi[1:] + dphi[:-1]))])
    twist = x[0] if joint.masses > 1 else None
    return Trajectory(joint, problem.theta, h, u, x, phi, dphi, twist, rescued, record.begin)


@dataclass(slots=True, eq=False)
class Following(Problem):
    """The motor moves as guessed, and drives all other states; good for a guess."""

    tolerance = 1e-2

    def linearise(self, first: int, last: int, x: Array) -> Steps:
        joint, steps = self.joint, linearise(self.motive(first, last), x[:, :-1], x[:, 1:])
        given = slice(joint.speeds.start - joint.keeps_angle, joint.speeds.start + 1)
        steps.G[given], steps.c[given] = 0.0, 0.0
        return steps


def follow_motor(problem: Problem, x0: Array) -> Array:
    """The guess with all states but the motor's as its motion drives them, (nx, n).

    Friction decides by the forces whether a motor near rest stays there, so the gear's torque must be about right.
    """
    joint, h = problem.joint, problem.sampling_time
    if joint.nx == 1 + joint.keeps_angle:
        return problem.guess
    following = Following(joint, problem.theta, problem.u, h, problem.guess, begin=problem.begin)
    try:
        return integrate(following, x0, _hold)
    except NumericsError:
        return problem.guess


def _hold(problem: Problem, first: int, stop: int, start: Array) -> Array:
    return np.asarray(np.concatenate([start[:, None], problem.guess[:, first + 1 : stop + 1]], axis=1))


def effective_torque(joint: Joint, theta: Array, record: Record) -> Array:
    """The torque that acts, mean over each interval, after the channels on it, (n,)."""
    u = record.tau_m
    for _, channel, p, _ in joint.channels_on(theta, Signal.TORQUE):
        u = channel.apply(u, record.sampling_time, p)
    return u


def torque_columns(joint: Joint, theta: Array, record: Record) -> dict[int, Array]:
    """Derivatives of the effective torque to the channels' parameters: index into theta -> (n,)."""
    u, h, columns = record.tau_m, record.sampling_time, dict[int, Array]()
    for _, channel, p, first in joint.channels_on(theta, Signal.TORQUE):
        columns = {k: channel.push(c, u, h, p) for k, c in columns.items()}
        columns |= dict(enumerate(channel.partials(u, h, p), start=first))
        u = channel.apply(u, h, p)
    return columns


def initial_state(joint: Joint, theta: Array, record: Record) -> Array:
    """First state as measured, the arm moving rigidly with the motor and the gear untwisted, (nx,)."""
    return measured_guess(joint, joint.in_record(theta, record.name), record)[:, 0]


def measured_guess(joint: Joint, theta: Array, record: Record) -> Array:
    """The measured motion as states, arm and tool rigid, memory settled, (nx, n).

    A speed lost in its own noise is taken for rest: where friction holds, noise would pass for a host of reversals.
    """
    x = np.zeros((joint.nx, len(record)))
    first = joint.speeds.start
    if joint.keeps_angle:
        x[first - 1] = record.phi_m
    noise = np.median(np.abs(np.diff(record.dphi_m, 2))) / (0.6745 * np.sqrt(6.0))
    x[first] = np.where(np.abs(record.dphi_m) > 3 * noise, record.dphi_m, 0.0) if joint.dry else record.dphi_m
    x[first + 1 : joint.speeds.stop] = joint.ratio * x[first]
    return joint.settled(x, np.sign(x[joint.speeds]), record.t, theta)


def sensitivities(
    trajectory: Trajectory,
    record: Record,
    columns: Sequence[int],
    rows: Sequence[int],
    free_states: Sequence[int] = (),
    forces: Array | None = None,
) -> Array:
    """Derivatives of states `rows` to parameters `columns`, to initial states `free_states`, and to the size of
    `forces` (nv, q, n), generalised forces on the coordinates, each held over its interval: (rows, k, n).

    One banded triangular solve a block of samples; only the wanted rows are kept.
    """
    joint, theta, n = trajectory.joint, trajectory.theta, len(trajectory.u)
    forces = np.zeros((joint.masses, 0, n)) if forces is None else forces
    moved = joint.sources(columns, record.name)
    mechanical = list(dict.fromkeys(k for k in moved if k is not None and k < joint.n_theta))  # each once
    inputs = [-1 - j for j in range(joint.masses)] if forces.size else []
    channel = torque_columns(joint, theta, record)
    given = len(columns) + len(free_states)
    width = given + forces.shape[1]
    out = np.empty((len(rows), width, n))
    start = np.zeros((joint.nx, width))
    start[list(free_states), len(columns) + np.arange(len(free_states))] = 1.0
    problem = Problem(joint, theta, trajectory.u[:-1], trajectory.sampling_time, trajectory.x, begin=record.begin)
    out[:, :, 0] = start[list(rows)]
    for first in range(0, n - 1, BLOCK):
        last = min(n - 1, first + BLOCK)
        motive = problem.motive(first, last, [*mechanical, *inputs])
        steps = linearise(motive, trajectory.x[:, first:last], trajectory.x[:, first + 1 : last + 1])
        assert steps.S is not None
        forcing = np.zeros((width, last - first + 1, joint.nx)).transpose(2, 0, 1)
        forcing[:, :, 0] = start
        for k, column in enumerate(moved):
            if column is None:
                continue
            if column < joint.n_theta:
                forcing[:, k, 1:] = steps.S[:, mechanical.index(column)]
            elif column in channel:
                forcing[:, k, 1:] = steps.S[:, -1] * channel[column][first:last]
        pushed = steps.S[:, len(mechanical) : -1]
        np.einsum("ijn,jqn->iqn", pushed, forces[: len(inputs), :, first:last], out=forcing[:, given:, 1:])
        z = solve_block_bidiagonal(steps, forcing)
        out[:, :, first : last + 1] = z[list(rows)]
        start = z[:, :, -1]
    return out
