"""Several coupled joints, each under its sampled controller, solved window by window like one joint.

As in the loop of one joint, the integrals of the controllers join the unknowns of a window and their gains the Newton
matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.integrate import solve_ivp

from robotid.errors import NumericsError
from robotid.interrupt import check
from robotid.model.array import Array
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.loop import ControlledJoint, Drive
from robotid.simulation.coupled.coupled_joints import CoupledJoints
from robotid.simulation.coupled.planar_chain import PlanarChain
from robotid.simulation.friction.crossing import linearise_steps
from robotid.simulation.friction.step import StepInputs, Steps
from robotid.simulation.newton.problem import FIRST_WINDOW, TOLERANCE
from robotid.simulation.newton.solver import MAX_STATE, integrate

RTOL, ATOL = 1e-8, 1e-11  # of the fallback
SMOOTHING = 1e-4  # rad/s in which its dry friction turns

_solve_ivp: Any = solve_ivp  # its types take every right-hand side for complex


@dataclass(frozen=True, slots=True, eq=False)
class AxisRun:
    """One axis of a run: states x (nx, n) of its joint, and torque (n,) [Nm], disturbance included."""

    x: Array
    torque: Array


def follow(
    axes: Sequence[ControlledJoint],
    body: PlanarChain,
    references: Sequence[Reference],
    speed_noise: Array | None = None,
    pose: Sequence[float] = (),
) -> tuple[AxisRun, ...]:
    """The motion of all axes that their references, one each and all of n samples, cause.

    speed_noise : (axes, n) [rad/s] added to the measured speeds; pose : angles [rad] of the arms at the start, where a
    controller of position begins at its reference instead; by default zero. All begins at rest, without twist.
    Raises NumericsError where the loop diverges.
    """
    noise = np.zeros((len(axes), len(references[0]))) if speed_noise is None else speed_noise
    drives = [Drive(*one) for one in zip(axes, references, noise, strict=True)]
    mechanism = CoupledJoints([axis.joint for axis in axes], body)
    x0 = np.zeros(mechanism.nx)
    for k, (axis, reference) in enumerate(zip(axes, references, strict=True)):
        start = reference.ref[0] if reference.kind == "position" else (pose[k] if pose else 0.0) / axis.joint.ratio
        x0[mechanism.rows(k)[axis.joint.motor_angle]] = start
    return CoupledLoop(mechanism, drives).run(x0)


class CoupledLoop:
    """One run of coupled joints under their controllers, a problem for `TrajectoryNewton`: the states of the mechanism,
    then the controllers' integrals [rad]. A run is for one use."""

    tolerance: ClassVar[float] = TOLERANCE
    max_failed_windows: ClassVar[int | None] = None
    first_window: ClassVar[int] = FIRST_WINDOW

    def __init__(self, mechanism: CoupledJoints, drives: Sequence[Drive]) -> None:
        self.joint = mechanism
        self.sampling_time = drives[0].sampling_time
        samples = len(drives[0].command)
        self.intervals = samples - 1
        self._drives = tuple(drives)
        self._theta = np.concatenate([drive.controlled.theta for drive in drives])
        self._u = np.zeros((samples - 1, len(drives)))
        self.guess = np.zeros((mechanism.nx + len(drives), samples))
        for k, drive in enumerate(drives):
            self.guess[mechanism.rows(k)] = drive.guess[:-1]

    def run(self, x0: Array) -> tuple[AxisRun, ...]:
        """All axes from the first state x0 (nx,) of the mechanism."""
        x = integrate(self, np.append(x0, np.zeros(len(self._drives))), self._sample_by_sample)
        every, axes = slice(None), range(len(self._drives))
        own = [self._of_axis(k, x) for k in axes]
        return tuple(AxisRun(own[k][:-1], self._drives[k].respond(every, own[k])[1]) for k in axes)

    def linearise(self, first: int, last: int, x: Array) -> Steps:
        """Intervals first .. last - 1 linearised at their nodes x (states, last - first + 1)."""
        nx, m, h = self.joint.nx, last - first, self.sampling_time
        errors, slopes = self._act(first, last, x[:, :-1])
        inputs = self._inputs(first, last)
        steps = linearise_steps(inputs, x[:nx, :-1], x[:nx, 1:])
        assert steps.S is not None
        G = np.zeros((len(x), len(x), m))
        G[:nx, :nx] = steps.G
        for k, drive in enumerate(self._drives):
            c, rows, slope = drive.controlled.controller, self.joint.rows(k), slopes[k]
            gain = drive.error_gain[:, None] * slope
            G[:nx, rows] += steps.S[:, k : k + 1] * (c.kp * gain)[None]
            G[:nx, nx + k] = steps.S[:, k] * (c.ki * slope)
            G[nx + k, rows], G[nx + k, nx + k] = h * gain, 1.0
        defect = x[nx:, :-1] + h * slopes * errors - x[nx:, 1:]
        return Steps(G, np.concatenate([steps.c, defect]), None, steps.start, steps.end)

    def _of_axis(self, k: int, x: Array) -> Array:
        """The states of one joint and the integral of its controller, (nx of it + 1, m)."""
        return np.asarray(x[[*self.joint.rows(k), self.joint.nx + k]])

    def _act(self, first: int, last: int, x: Array) -> tuple[Array, Array]:
        """Let all controllers act in intervals first .. last - 1 from their first nodes: speed errors and slopes of the
        commands to them, (axes, m) each."""
        at = slice(first, last)
        acted = [drive.act(at, self._of_axis(k, x)) for k, drive in enumerate(self._drives)]
        self._u[at] = np.stack([torque.mean for _, _, torque in acted], axis=1)
        return np.array([error for error, _, _ in acted]), np.array([slope for _, slope, _ in acted])

    def _inputs(self, first: int, last: int) -> StepInputs:
        t, h = np.arange(first, last, dtype=np.float64) * self.sampling_time, self.sampling_time
        return StepInputs(self.joint, self._theta, self._u[first:last], t, h, self.joint.motor_columns)

    def _sample_by_sample(self, first: int, stop: int, start: Array) -> Array:
        """The fallback: controllers and mechanism in turn, dry friction smoothed."""
        x, nx, h = [start], self.joint.nx, self.sampling_time
        for k in range(first, stop):
            check()
            errors, slopes = self._act(k, k + 1, x[-1][:, None])
            step = _solve_ivp(self._rate, (k * h, (k + 1) * h), x[-1][:nx], "LSODA", args=(k,), rtol=RTOL, atol=ATOL)
            if not step.success or not np.abs(step.y[:, -1]).max() < MAX_STATE:
                raise NumericsError(
                    f"the simulation diverges at t = {k * h:.4g} s", hint="check the parameters and the controllers"
                )
            x.append(np.append(step.y[:, -1], x[-1][nx:] + h * slopes[:, 0] * errors[:, 0]))
        return np.stack(x, axis=1)

    def _rate(self, t: float, x: Array, k: int) -> Array:
        v = x[self.joint.speeds, None]
        s = v / np.sqrt(v**2 + SMOOTHING**2)
        return self.joint.evaluate(x[:, None], self._u[k : k + 1], s, np.array([t]), self._theta).f[:, 0]
