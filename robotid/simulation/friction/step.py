"""What the steps over sampling intervals start from, and what they yield. Intervals are the last axis of arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from robotid.model.array import Array, Index, Mask
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Dynamics, EdgeDistances
from robotid.signals.torque_steps import TorqueSteps, in_a_row


class Mechanism(Protocol):
    """What a step and the solver ask of equations of motion; `Joint` says what each means.

    speeds : rows of the state that are speeds, one a mass. dry : the masses on which dry friction acts. edges : how
    many there are; state_limits : by row. The torque u is (n,), or (n, axes) where there are several motors.
    """

    @property
    def nx(self) -> int: ...

    @property
    def masses(self) -> int: ...

    @property
    def edges(self) -> int: ...

    @property
    def dry(self) -> tuple[int, ...]: ...

    @property
    def speeds(self) -> slice: ...

    @property
    def state_limits(self) -> Mapping[int, float]: ...

    def linear_at(self, theta: Array) -> Any: ...

    def force(self, x: Array, u: Array, s: Array, t: Array, theta: Array, linear: Any = None) -> Array: ...

    def directions(self, x: Array, s: Array, t: Array, theta: Array) -> Array: ...

    def distances(self, x: Array, s: Array, t: Array, theta: Array) -> Array: ...

    def distance_slopes(
        self, x: Array, s: Array, t: Array, theta: Array, columns: DerivativeColumns | None = None
    ) -> EdgeDistances: ...

    def evaluate(
        self,
        x: Array,
        u: Array,
        s: Array,
        t: Array,
        theta: Array,
        sticking: Mask | None = None,
        columns: DerivativeColumns | None = None,
        linear: Any = None,
    ) -> Dynamics: ...


# Not frozen, as all that is made afresh for every step: freezing costs more than the arithmetic of a few of them.
@dataclass(slots=True, eq=False)
class StepInputs:
    """What acts during n steps.

    theta : (p,) parameters of the joint; u : (n,) or (n, axes) motor torque, constant during each step but for
    torque_steps; t : (n,) start times [s]; h : lengths [s], (n,) or the same for all; columns : what to differentiate
    to besides the states, None for nothing; linear : what `linear_at` says at these parameters, None where it is not
    known yet.
    """

    joint: Mechanism
    theta: Array
    u: Array
    t: Array
    h: Array | float
    columns: DerivativeColumns | None = None
    linear: Any = None
    torque_steps: TorqueSteps | None = None

    @property
    def width(self) -> int:
        """How many columns there are besides those to the states."""
        return 0 if self.columns is None else self.columns.width

    def take(self, where: Index | slice) -> StepInputs:
        """The steps at these indices."""
        h = self.h if isinstance(self.h, float) else self.h[where]
        steps = None if self.torque_steps is None else self.torque_steps.take(where)
        return StepInputs(self.joint, self.theta, self.u[where], self.t[where], h, self.columns, self.linear, steps)

    def with_duration(self, h: Array, t: Array) -> StepInputs:
        """The same steps with other lengths h and start times t, (n,) [s]."""
        return StepInputs(self.joint, self.theta, self.u, t, h, self.columns, self.linear)


def joined(parts: Sequence[StepInputs]) -> StepInputs:
    """The steps of several stretches of time, of one joint with the same parameters, one after the other."""
    first, u, t = parts[0], np.concatenate([one.u for one in parts]), np.concatenate([one.t for one in parts])
    steps = in_a_row([(one.torque_steps, len(one.u)) for one in parts])
    if isinstance(first.h, float) and all(one.h is first.h or one.h == first.h for one in parts):
        return replace(first, u=u, t=t, torque_steps=steps)
    h = np.concatenate([np.broadcast_to(one.h, len(one.u)) for one in parts])
    return replace(first, u=u, t=t, h=h, torque_steps=steps)


@dataclass(slots=True, eq=False)
class Steps:
    """Linearised steps x[n+1] = x1[n] + c + G (x[n] - x0[n]) + S dtheta about nodes x0, x1 (nx, n).

    G : (nx, nx, n); c : (nx, n) the defect of the nodes, solved for the end of the step; S : (nx, k + 1, n) or None,
    the derivatives to the parameters wanted and, last, to the torque of the interval; start, end : (nx, n) rates of
    the states at both nodes, in the mode in which the step begins and ends; within : (nx, 2, n) derivatives to size and
    share of the torque's step in the interval, None where there is none or S is None.
    """

    G: Array
    c: Array
    S: Array | None
    start: Array
    end: Array
    within: Array | None = None

    @classmethod
    def empty(cls, nx: int, width: int, n: int, *, stepped: bool = False) -> Steps:
        """Steps that are still to be put. stepped : some of them with a torque that changes within its interval."""
        c, start, end = np.empty((3, nx, n))
        S, within = np.empty((nx, width, n)) if width else None, np.zeros((nx, 2, n)) if stepped and width else None
        return cls(np.empty((nx, nx, n)), c, S, start, end, within)

    def put(self, where: Index | slice, other: Steps) -> None:
        """Replace the steps at these indices, in place."""
        self.G[:, :, where], self.c[:, where] = other.G, other.c
        self.start[:, where], self.end[:, where] = other.start, other.end
        if self.S is not None and other.S is not None:
            self.S[:, :, where] = other.S
        if self.within is not None and other.within is not None:
            self.within[:, :, where] = other.within

    def part(self, at: slice) -> Steps:
        """The steps of these intervals."""
        S, within = (None if one is None else one[:, :, at] for one in (self.S, self.within))
        return Steps(self.G[:, :, at], self.c[:, at], S, self.start[:, at], self.end[:, at], within)

    def with_prescribed(self, rows: slice) -> Steps:
        """The same steps where the nodes of these states are given, and nothing changes them."""
        G, c = self.G.copy(), self.c.copy()
        G[rows], c[rows] = 0.0, 0.0
        return replace(self, G=G, c=c)
