"""A simulated motion, and its linearisation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from robotid.model.array import Array, blocks
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.signals.record import SpeedOrigin
from robotid.signals.torque_steps import TorqueSteps
from robotid.simulation.friction.crossing import linearise_steps
from robotid.simulation.friction.mode import friction_mode
from robotid.simulation.friction.step import StepInputs, Steps, joined
from robotid.simulation.in_turns import InTurns, beside_all
from robotid.simulation.newton.problem import Problem

BLOCK = 4000  # intervals whose derivatives are in memory at once
TOGETHER = 100_000  # samples of several trajectories, likewise


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A simulated motion at the n samples of a record.

    x : (nx, n) states; phi_m, dphi_m : (n,) [rad, rad/s]; twist : (n,) of the gear [rad], None for a rigid joint;
    u : (n,) effective torque; fallback_windows : samples (first, stop) that LSODA had to integrate; failed_windows :
    the least max_failed_windows of `simulate` that allows it; begin [s] : of the record; speed_origin : how the record
    has its speed; torque_steps : how u changes within the intervals, None where it is held.
    """

    joint: Joint
    theta: Array
    sampling_time: float
    u: Array
    x: Array
    phi_m: Array
    dphi_m: Array
    twist: Array | None
    fallback_windows: tuple[tuple[int, int], ...] = ()
    failed_windows: int = 0
    begin: float = 0.0
    speed_origin: SpeedOrigin = "sensor"
    torque_steps: TorqueSteps | None = None

    @property
    def t(self) -> Array:
        """Times of the samples [s], (n,)."""
        return np.asarray(self.begin + np.arange(len(self.u), dtype=np.float64) * self.sampling_time)

    @property
    def dtwist(self) -> Array | None:
        """Rate of the gear's twist [rad/s], (n,); None for a rigid joint."""
        return None if self.twist is None else gear_rate(self.joint, self.x)

    @property
    def ddphi_m(self) -> Array:
        """Motor acceleration at the start of each interval [rad/s2], (n,)."""
        joint, row = self.joint, self.joint.motor_speed
        parts = []
        for at in blocks(len(self.u), BLOCK):
            inputs, x = self.step_inputs(at), self.x[:, at]
            mode = friction_mode(inputs, x)
            parts.append(joint.evaluate(x, inputs.u, mode.s, inputs.t, self.theta, mode.sticking).f[row])
        return np.concatenate(parts)

    def part(self, at: slice) -> Trajectory:
        """These samples of it."""
        return replace(
            self,
            u=self.u[at],
            x=self.x[:, at],
            phi_m=self.phi_m[at],
            dphi_m=self.dphi_m[at],
            twist=None if self.twist is None else self.twist[at],
            fallback_windows=(),
            failed_windows=0,
            begin=self.begin + at.start * self.sampling_time,
            torque_steps=None if self.torque_steps is None else self.torque_steps.take(at),
        )

    def step_inputs(self, at: slice, columns: DerivativeColumns | None = None) -> StepInputs:
        """What acts in the intervals after these samples. columns : what to differentiate to
        besides the states."""
        problem = Problem(
            self.joint,
            self.theta,
            self.u,
            self.sampling_time,
            self.x,
            begin=self.begin,
            torque_steps=self.torque_steps,
        )
        return problem.inputs(at, columns)

    def linearise(self, at: slice, columns: DerivativeColumns | None = None) -> Steps:
        """The steps of the intervals after these samples, the last of all excepted, with derivatives to parameters."""
        x1 = self.x[:, at.start + 1 : at.stop + 1]
        return linearise_steps(self.step_inputs(at, columns), self.x[:, at], x1)


def gear_rate(joint: Joint, x: Array) -> Array:
    """Rate of the gear's twist [rad/s] in states x (nx, n) of a flexible joint, (n,)."""
    dq = x[joint.speeds]
    return np.asarray(joint.ratio * dq[0] - dq[1])


def linearised_together(trajectories: Sequence[Trajectory], columns: DerivativeColumns, among: InTurns) -> list[Steps]:
    """All steps of trajectories of one joint with the same parameters, crossings of all of them at once. among : the
    joint beside all their records, as of `shared_dynamics`."""
    trajectories = [
        replace(one, joint=among.joint, begin=among.begin(k, one.begin)) for k, one in enumerate(trajectories)
    ]
    every = [slice(0, len(one.u) - 1) for one in trajectories]
    inputs = joined([one.step_inputs(at, columns) for one, at in zip(trajectories, every, strict=True)])
    x0, x1 = (np.concatenate([one.x[:, at] for one in trajectories], axis=1) for at in (slice(-1), slice(1, None)))
    steps, edges = linearise_steps(inputs, x0, x1), np.cumsum([0, *(at.stop for at in every)]).tolist()
    return [steps.part(slice(a, b)) for a, b in pairwise(edges)]


def linearised_each(trajectories: Sequence[Trajectory], columns: DerivativeColumns) -> list[Steps]:
    """All steps of each trajectory, in memory at once; found together where that pays."""
    among = shared_dynamics(trajectories) if len(trajectories) > 1 else None
    if among is not None:
        return linearised_together(trajectories, columns, among)
    return [one.linearise(slice(0, len(one.u) - 1), columns) for one in trajectories]


def shared_dynamics(trajectories: Sequence[Trajectory]) -> InTurns | None:
    """The joint of trajectories beside all their records, where they have the same parameters and are few enough to
    linearise at once."""
    first = trajectories[0]
    alike = all(np.array_equal(one.theta, first.theta) for one in trajectories)
    if not alike or sum(len(one.u) for one in trajectories) > TOGETHER:
        return None
    return beside_all([one.joint for one in trajectories])
