"""What the solver simulates: a joint under a given torque, or anything else that yields linearised steps."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Protocol

import numpy as np

from robotid.model.array import Array
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.model.linear_part import LinearPart
from robotid.signals.torque_steps import TorqueSteps
from robotid.simulation.friction.crossing import linearise_steps
from robotid.simulation.friction.step import Mechanism, StepInputs, Steps

FIRST_WINDOW = 2000  # samples, where the guess is the measured motion
NEAR_WINDOW = 8000  # samples, where it is a trajectory nearby
TOLERANCE = 1e-4  # of the last Newton step, relative; the error left is of the order of its square


class WindowProblem(Protocol):
    """What `TrajectoryNewton` asks of a problem over n intervals, its first states those of `joint`.

    tolerance : a Newton step that is smaller, relative to the trajectory, ends the iteration. max_failed_windows : how
    many windows may fail to settle, or cost as much by being slow, before the simulation counts as divergent, None for
    any number. first_window : how many samples the first window tries.
    """

    @property
    def joint(self) -> Mechanism: ...

    @property
    def sampling_time(self) -> float: ...

    @property
    def guess(self) -> Array:
        """A trajectory nearby, (states, n + 1)."""
        ...

    @property
    def intervals(self) -> int: ...

    @property
    def tolerance(self) -> float: ...

    @property
    def max_failed_windows(self) -> int | None: ...

    @property
    def first_window(self) -> int: ...

    def linearise(self, first: int, last: int, x: Array) -> Steps:
        """Intervals first .. last - 1 linearised at their nodes x (states, last - first + 1)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """A joint under a given torque.

    theta : (p,); u : (n,) effective motor torque, constant over each of the n intervals but for torque_steps;
    sampling_time [s]; guess : (nx, n + 1) of the nodes; begin [s] : time of the first node; linear : what of the joint
    is the same at every sample. The rest as of `WindowProblem`.
    """

    joint: Joint
    theta: Array
    u: Array
    sampling_time: float
    guess: Array
    begin: float = field(default=0.0, kw_only=True)
    torque_steps: TorqueSteps | None = field(default=None, kw_only=True)
    max_failed_windows: int | None = field(default=None, kw_only=True)
    first_window: int = field(default=FIRST_WINDOW, kw_only=True)
    linear: LinearPart = field(init=False)
    tolerance: ClassVar[float] = TOLERANCE

    def __post_init__(self) -> None:
        object.__setattr__(self, "linear", self.joint.linear_at(self.theta))

    @property
    def intervals(self) -> int:
        return len(self.u)

    def linearise(self, first: int, last: int, x: Array) -> Steps:
        """Intervals first .. last - 1 linearised at their nodes x (nx, last - first + 1)."""
        return self.moving(linearise_steps(self.inputs(slice(first, last)), x[:, :-1], x[:, 1:]))

    def moving(self, steps: Steps) -> Steps:
        """The steps of what is simulated, of those of the joint."""
        return steps

    def inputs(self, at: slice, columns: DerivativeColumns | None = None) -> StepInputs:
        """What acts in these intervals. columns : what to differentiate to besides."""
        h = self.sampling_time
        t = self.begin + np.arange(at.start, at.stop, dtype=np.float64) * h
        steps = None if self.torque_steps is None else self.torque_steps.take(at)
        return StepInputs(self.joint, self.theta, self.u[at], t, h, columns, self.linear, steps)
