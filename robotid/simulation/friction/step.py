"""What the steps over sampling intervals start from, and what they yield. Intervals are the last axis of arrays."""

from __future__ import annotations

from dataclasses import dataclass, replace

from robotid.model.array import Array, Index
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint


@dataclass(frozen=True, slots=True, eq=False)
class StepInputs:
    """What acts during n steps.

    theta : (p,) parameters of the joint; u : (n,) motor torque, constant during each step; t, h : (n,) start times and
    lengths [s]; columns : what to differentiate to besides the states, None for nothing.
    """

    joint: Joint
    theta: Array
    u: Array
    t: Array
    h: Array
    columns: DerivativeColumns | None = None

    def take(self, where: Index) -> StepInputs:
        """The steps at these indices."""
        return StepInputs(self.joint, self.theta, self.u[where], self.t[where], self.h[where], self.columns)

    def with_duration(self, h: Array, t: Array) -> StepInputs:
        """The same steps with other lengths h and start times t, (n,) [s]."""
        return StepInputs(self.joint, self.theta, self.u, t, h, self.columns)


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """Linearised steps x[n+1] = x1[n] + c + G (x[n] - x0[n]) + S dtheta about nodes x0, x1 (nx, n).

    G : (nx, nx, n); c : (nx, n) the defect of the nodes, solved for the end of the step; S : (nx, k + 1, n) or None,
    the derivatives to the parameters wanted and, last, to the torque of the interval; end : (nx, n) rate of the
    states where each step ends.
    """

    G: Array
    c: Array
    S: Array | None
    end: Array

    def put(self, where: Index, other: Steps) -> None:
        """Replace the steps at these indices, in place."""
        self.G[:, :, where], self.c[:, where], self.end[:, where] = other.G, other.c, other.end
        if self.S is not None and other.S is not None:
            self.S[:, :, where] = other.S

    def with_prescribed(self, rows: slice) -> Steps:
        """The same steps where the nodes of these states are given, and nothing changes them."""
        G, c = self.G.copy(), self.c.copy()
        G[rows], c[rows] = 0.0, 0.0
        return replace(self, G=G, c=c)
