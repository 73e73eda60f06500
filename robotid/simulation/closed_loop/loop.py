"""A joint under its sampled controller, solved window by window as in open loop.

The controller is causal, so its integral joins the unknowns of a window and its gains the Newton matrix. What is not
smooth (the encoder's quantisation) or has memory (channels on the torque) is taken from the last iterate: it settles
sample by sample from the first, as the rest does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from robotid.model.array import Array
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.signals.reference import Reference
from robotid.signals.torque_steps import TorqueSteps
from robotid.simulation.actuator import ActingTorque, changes_within, through_channels
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.fallback.lsoda import lsoda
from robotid.simulation.friction.crossing import linearise_steps
from robotid.simulation.friction.step import Steps
from robotid.simulation.newton.problem import FIRST_WINDOW, TOLERANCE, Problem
from robotid.simulation.newton.solver import integrate
from robotid.simulation.sensors import sensor_signals


@dataclass(frozen=True, slots=True, eq=False)
class ControlledJoint:
    """A joint that keeps its angle, with its parameters theta (p,), under a controller that sees its sensors.

    quantum [rad] : resolution of the encoder, zero for a perfect one.
    """

    joint: Joint
    theta: Array
    controller: Controller
    quantum: float = 0.0

    def follow(
        self,
        reference: Reference,
        speed_noise: Array | None = None,
        x0: Array | None = None,
        disturbance: Array | None = None,
    ) -> tuple[Array, Array]:
        """The motion that a reference of n samples causes: states x (nx, n), torque (n,) [Nm].

        speed_noise : (n,) [rad/s] added to the measured speed, by default none; x0 : (nx,) first state, by default at
        rest where the reference begins; disturbance : (n,) [Nm] added to the controller's command, by default none.
        Raises NumericsError where the loop diverges.
        """
        joint = self.joint
        if x0 is None:
            x0 = np.zeros(joint.nx)
            x0[joint.motor_angle] = reference.ref[0] if reference.kind == "position" else 0.0
        return ClosedLoop(Drive(self, reference, speed_noise, disturbance)).run(x0)


class Drive:
    """The controller of one joint in one run: what it commands from sample to sample, and the torque that acts.

    While a run advances, the drive remembers what came before: command (n,) [Nm], disturbance included, and the motion
    that the sensors have seen. guess (nx + 1, n) : of the joint's states and of the controller's integral [rad].
    """

    def __init__(
        self,
        controlled: ControlledJoint,
        reference: Reference,
        speed_noise: Array | None = None,
        disturbance: Array | None = None,
    ) -> None:
        none = np.zeros(len(reference.ref))
        self.controlled, self.sampling_time = controlled, reference.sampling_time
        self.guess = _rigid_guess(controlled.joint, reference)
        self.command = none.copy()
        self._ref = reference.ref
        self._speed_noise = none if speed_noise is None else speed_noise
        self._disturbance = none if disturbance is None else disturbance
        self._dref = np.diff(reference.ref, append=reference.ref[-1]) / reference.sampling_time
        self._motion = self.guess[controlled.joint.motor_states].copy()

    def act(self, at: slice, x: Array) -> tuple[Array, Array, ActingTorque]:
        """Let the controller act in some intervals from their first nodes x (nx + 1, m): speed error, slope of the
        command to it, zero in saturation, and the torque that acts, (m,) each."""
        error, self.command[at], slope = self.respond(at, x)
        controlled, history = self.controlled, self.command[: at.stop]
        acting = through_channels(controlled.joint, controlled.theta, self.sampling_time, history)
        return error, slope, acting.take(at)

    def respond(self, at: slice, x: Array) -> tuple[Array, Array, Array]:
        """Speed error, torque and its slope to it, zero in saturation, (m,) each, at nodes x (nx + 1, m). The torque is
        the controller's command with the disturbance."""
        controller, quantum = self.controlled.controller, self.controlled.quantum
        phi, dphi = self._seen(at, x)
        error = controller.error(self._ref[at], quantise(phi, quantum), dphi + self._speed_noise[at])
        command, slope = controller.torque(error, x[-1], self._dref[at])
        return error, command + self._disturbance[at], slope

    @property
    def error_gain(self) -> Array:
        """Derivative of the speed error to the joint's states, (nx,)."""
        joint, controller = self.controlled.joint, self.controlled.controller
        gain = np.zeros(joint.nx)
        gain[joint.motor_speed] = -1.0
        if controller.kind == "position":
            gain[joint.motor_angle] = -controller.kpos
        return gain

    def _seen(self, at: slice, x: Array) -> tuple[Array, Array]:
        """Angle and speed as their sensors show them at nodes x (nx + 1, m), before noise."""
        controlled = self.controlled
        self._motion[:, at] = x[controlled.joint.motor_states]
        seen = self._motion[:, : at.stop]
        phi, dphi = sensor_signals(controlled.joint, controlled.theta, self.sampling_time, *seen)
        return phi[at], dphi[at]


class ClosedLoop:
    """One run of a controlled joint, a problem for `TrajectoryNewton` with states (x, I), I [rad] the controller's
    integral. A run is for one use.
    """

    tolerance: ClassVar[float] = TOLERANCE
    max_failed_windows: ClassVar[int | None] = None
    first_window: ClassVar[int] = FIRST_WINDOW

    def __init__(self, drive: Drive) -> None:
        self.joint, self.sampling_time, self.guess = drive.controlled.joint, drive.sampling_time, drive.guess
        self.intervals = len(drive.command) - 1
        self._drive = drive
        theta, n = drive.controlled.theta, self.intervals
        steps = TorqueSteps.none(n) if changes_within(self.joint) else None
        self._open = Problem(self.joint, theta, np.zeros(n), self.sampling_time, self.guess[:-1], torque_steps=steps)

    def run(self, x0: Array) -> tuple[Array, Array]:
        """States x (nx, n) of the joint from its first state x0 (nx,), and the torque with its disturbance (n,)."""
        x = integrate(self, np.append(x0, 0.0), self._sample_by_sample)
        _, command, _ = self._drive.respond(slice(None), x)
        return x[:-1], command

    def linearise(self, first: int, last: int, x: Array) -> Steps:
        """Intervals first .. last - 1 linearised at their nodes x (nx + 1, last - first + 1)."""
        nx, h, c = self.joint.nx, self.sampling_time, self._drive.controlled.controller
        error, slope = self._act(first, last, x[:, :-1])
        steps = linearise_steps(self._open.inputs(slice(first, last), DerivativeColumns()), x[:nx, :-1], x[:nx, 1:])
        assert steps.S is not None
        gain = self._drive.error_gain
        G = np.zeros((nx + 1, nx + 1, last - first))
        G[:nx, :nx] = steps.G + steps.S[:, :1] * (c.kp * slope * gain[:, None])[None]
        G[:nx, nx] = steps.S[:, 0] * (c.ki * slope)
        G[nx, :nx], G[nx, nx] = h * slope * gain[:, None], 1.0
        defect = x[nx, :-1] + h * slope * error - x[nx, 1:]
        return Steps(G, np.concatenate([steps.c, defect[None]]), None, steps.start, steps.end)

    def _act(self, first: int, last: int, x: Array) -> tuple[Array, Array]:
        """Let the controller act in intervals first .. last - 1 from their first nodes: speed error and slope."""
        at = slice(first, last)
        error, slope, torque = self._drive.act(at, x)
        self._open.u[at] = torque.mean
        if self._open.torque_steps is not None:
            steps = TorqueSteps.none(last - first) if torque.steps is None else torque.steps
            self._open.torque_steps.share[at], self._open.torque_steps.step[at] = steps.share, steps.step
        return error, slope

    def _sample_by_sample(self, first: int, stop: int, start: Array) -> Array:
        """The fallback: controller and joint in turn."""
        x, h = [start], self.sampling_time
        for k in range(first, stop):
            error, slope = self._act(k, k + 1, x[-1][:, None])
            end = lsoda(self._open, k, k + 1, x[-1][:-1])[:, -1]
            x.append(np.append(end, x[-1][-1] + h * slope[0] * error[0]))
        return np.stack(x, axis=1)


def quantise(angle: Array, quantum: float) -> Array:
    """Angle as an encoder of this resolution shows it, (n,)."""
    return np.asarray(np.round(angle / quantum) * quantum) if quantum > 0 else angle


def _rigid_guess(joint: Joint, reference: Reference) -> Array:
    """The reference followed exactly, all parts rigid, (nx + 1, n)."""
    ref, h = reference.ref, reference.sampling_time
    speed = np.gradient(ref, h) if reference.kind == "position" else ref
    guess = np.zeros((joint.nx + 1, len(ref)))
    guess[joint.motor_angle] = ref if reference.kind == "position" else np.cumsum(ref) * h
    guess[joint.motor_speed] = speed
    guess[joint.motor_speed + 1 : joint.speeds.stop] = joint.ratio * speed
    return guess
