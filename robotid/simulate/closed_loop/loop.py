"""A joint under its sampled controller, solved window by window as in open loop.

The controller is causal, so its integral joins the unknowns of a window and its gains the Newton matrix. What is not
smooth (the encoder's quantisation) or looks back (channels on the torque) is taken from the last iterate: it settles
sample by sample from the left, as the rest does.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robotid.model.array import Array
from robotid.model.port import Signal
from robotid.simulate.closed_loop.controller import Controller
from robotid.simulate.fallback.lsoda import lsoda
from robotid.simulate.friction.steps import StepInputs, Steps, linearise
from robotid.simulate.newton.solver import Problem, integrate
from robotid.simulate.sensors import shown


@dataclass(slots=True, eq=False)
class ClosedLoop(Problem):
    """State (x, I) of a joint that keeps its angle, with controller integral I [rad]; u (n,) is found on the way.

    ref (n + 1,) of the controller's kind; speed_noise (n + 1,) added to the measured speed; quantum [rad] of the
    encoder.
    """

    controller: Controller
    ref: Array
    speed_noise: Array
    quantum: float = 0.0
    dref: Array = field(init=False)
    command: Array = field(init=False)
    motion: Array = field(init=False)

    def __post_init__(self) -> None:
        Problem.__post_init__(self)
        self.dref = np.diff(self.ref, append=self.ref[-1]) / self.sampling_time
        self.command = np.zeros(len(self.ref))
        self.motion = self.guess[[self.joint.speeds.start - 1, self.joint.speeds.start]]

    def drive(self, at: slice, x: Array) -> tuple[Array, Array, Array]:
        """Speed error, torque command and its slope to it in saturation, at nodes x (nx + 1, m)."""
        phi, dphi = self.seen(at, x)
        error = self.controller.error(self.ref[at], quantise(phi, self.quantum), dphi + self.speed_noise[at])
        return error, *self.controller.torque(error, x[-1], self.dref[at])

    def seen(self, at: slice, x: Array) -> tuple[Array, Array]:
        """Angle and speed as their sensors show them at nodes x (nx + 1, m), before noise."""
        start = self.joint.speeds.start
        self.motion[:, at] = x[start - 1 : start + 1]
        phi, dphi = shown(self.joint, self.theta, self.sampling_time, *self.motion[:, : at.stop])
        return phi[at], dphi[at]

    def effective(self, last: int) -> Array:
        """The torque that acts in intervals 0 .. last - 1, after the channels on it, (last,)."""
        u = self.command[:last]
        for _, channel, p, _ in self.joint.channels_on(self.theta, Signal.TORQUE):
            u = channel.apply(u, self.sampling_time, p)
        return u

    def linearise(self, first: int, last: int, x: Array) -> Steps:
        nx, h, at = self.joint.nx, self.sampling_time, slice(first, last)
        error, self.command[at], slope = self.drive(at, x[:, :-1])
        self.u[at] = self.effective(last)[at]
        m = last - first
        motive = StepInputs(
            self.joint,
            self.theta,
            self.u[at],
            np.arange(first, last, dtype=np.float64) * h,
            np.full(m, h, dtype=np.float64),
            (),
        )
        steps = linearise(motive, x[:nx, :-1], x[:nx, 1:])
        assert steps.S is not None
        gain, c = self._error_gain(), self.controller
        G = np.zeros((nx + 1, nx + 1, m))
        G[:nx, :nx] = steps.G + steps.S[:, :1] * (c.kp * slope * gain[:, None])[None]
        G[:nx, nx] = steps.S[:, 0] * (c.ki * slope)
        G[nx, :nx], G[nx, nx] = h * slope * gain[:, None], 1.0
        defect = x[nx, :-1] + h * slope * error - x[nx, 1:]
        return Steps(G, np.concatenate([steps.c, defect[None]]), None, steps.end)

    def _error_gain(self) -> Array:
        gain, start = np.zeros(self.joint.nx), self.joint.speeds.start
        gain[start] = -1.0
        if self.controller.kind == "position":
            gain[start - 1] = -self.controller.kpos
        return gain


def quantise(angle: Array, quantum: float) -> Array:
    """Angle as an encoder of this resolution shows it, (n,)."""
    return np.asarray(np.round(angle / quantum) * quantum) if quantum > 0 else angle


def run_closed_loop(loop: ClosedLoop, x0: Array) -> Array:
    """Nodes (nx + 1, n + 1) of a closed loop from the joint's first state x0 (nx,); loop.command holds the torque."""
    x = integrate(loop, np.append(x0, 0.0), _sample_by_sample)
    _, loop.command[:], _ = loop.drive(slice(None), x)
    return x


def _sample_by_sample(problem: Problem, first: int, stop: int, start: Array) -> Array:
    assert isinstance(problem, ClosedLoop)
    x, h = [start], problem.sampling_time
    for k in range(first, stop):
        at = slice(k, k + 1)
        error, problem.command[at], slope = problem.drive(at, x[-1][:, None])
        problem.u[at] = problem.effective(k + 1)[at]
        one = Problem(problem.joint, problem.theta, problem.u, h, problem.guess[:-1])
        end = lsoda(one, k, k + 1, x[-1][:-1])[:, -1]
        x.append(np.append(end, x[-1][-1] + h * slope[0] * error[0]))
    return np.stack(x, axis=1)
