"""One implicit step for every sampling interval at once, with dry friction exact inside the step.

Regular steps are Hermite-Simpson (Lobatto IIIA, order 4; Hairer & Wanner 1996, table IV.5.7), one residual an
interval. Coulomb friction is set-valued, sgn(0) = [-1, 1]: a coordinate slips one way, the other way, or rests while
the friction it needs is within its level. Where the speed would cross zero inside an interval, the crossing instant
is solved for, and the rest of the interval goes on in the mode that the forces demand (Filippov 1988). Derivatives
pass through the crossing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, Index, Mask
from robotid.model.joint import Joint
from robotid.model.linear_algebra import product, solve

CROSSING_ITERATIONS = 5
CROSSING_TOLERANCE = 1e-5  # before the last, quadratically convergent, correction


@dataclass(frozen=True, slots=True)
class Steps:
    """Linearised steps x[n+1] = x1[n] + c + G (x[n] - x0[n]) + S dtheta.

    G (nx, nx, n), c (nx, n), S (nx, k + 1, n) or None, end : (nx, n) rate of the states where each step ends.
    The last column of S is the derivative to the torque held over the interval.
    """

    G: Array
    c: Array
    S: Array | None
    end: Array

    def put(self, where: Index, other: Steps) -> None:
        """Replace the steps at these indices."""
        self.G[:, :, where], self.c[:, where] = other.G, other.c
        if self.S is not None and other.S is not None:
            self.S[:, :, where] = other.S


@dataclass(frozen=True, slots=True)
class Motive:
    """What acts during n steps: torque u, start times t, lengths h, each (n,), theta, and derivative columns wanted."""

    joint: Joint
    theta: Array
    u: Array
    t: Array
    h: Array
    columns: Sequence[int] | None = None

    def part(self, where: Index, h: Array, t: Array) -> Motive:
        """The steps at these indices, with other lengths and start times."""
        return Motive(self.joint, self.theta, self.u[where], t, h, self.columns)


@dataclass(frozen=True, slots=True)
class Mode:
    """Direction of motion s (nv, n), and which coordinates friction holds at rest (nv, n), None where none is."""

    s: Array
    locked: Mask | None

    def part(self, where: Index) -> Mode:
        return Mode(self.s[:, where], None if self.locked is None else self.locked[:, where])


def modes(motive: Motive, x: Array) -> Mode:
    """Slip one way, the other, or rest, for states x (nx, n) at the start of their steps."""
    joint = motive.joint
    s = np.sign(x[joint.speeds])
    locked = np.zeros(s.shape, dtype=bool)
    for j in joint.dry:
        still = np.flatnonzero(s[j] == 0.0)
        if still.size:
            s[j, still], locked[j, still] = _break_away(motive, x, s, j, still)
    return Mode(s, locked if locked.any() else None)


def _break_away(motive: Motive, x: Array, s: Array, j: int, still: Index) -> tuple[Array, Mask]:
    joint, trial = motive.joint, s[:, still].copy()

    def pull(direction: float) -> Array:
        trial[j] = direction
        force = joint.force(x[:, still], motive.u[still], trial, motive.t[still], motive.theta)
        return np.asarray(force[j])

    forward, backward = pull(1.0) > 0.0, pull(-1.0) < 0.0
    return np.where(forward, 1.0, np.where(backward, -1.0, 0.0)), ~(forward | backward)


def linearise(motive: Motive, x0: Array, x1: Array) -> Steps:
    """All steps at the trajectory x0 (nx, n) -> x1 (nx, n), crossings included."""
    mode = modes(motive, x0)
    steps = regular(motive, x0, x1, mode)
    joint = motive.joint
    if joint.dry:
        v0, v1 = x0[joint.speeds], x1[joint.speeds] + steps.c[joint.speeds]
        crossing = mode.s * v1 < 0.0
        crossing[[j for j in range(joint.masses) if j not in joint.dry]] = False
        where = np.flatnonzero(crossing.any(axis=0))
        if where.size:
            share = np.where(crossing, v0 / np.where(crossing, v0 - v1, 1.0), np.inf)[:, where]
            first = np.argmin(share, axis=0)
            guess = np.clip(share[first, np.arange(where.size)], 0.0, 1.0)
            reached = x1[:, where] + steps.c[:, where]
            steps.put(where, cross(motive, where, x0[:, where], x1[:, where], reached, mode.part(where), first, guess))
    return steps


def regular(motive: Motive, x0: Array, x1: Array, mode: Mode) -> Steps:
    """Hermite-Simpson steps in a given mode."""
    joint, h, n = motive.joint, motive.h, x0.shape[1]
    theta, u, t, columns = motive.theta, motive.u, motive.t, motive.columns
    twice = None if mode.locked is None else np.concatenate([mode.locked, mode.locked], axis=1)
    ends = joint.evaluate(
        np.concatenate([x0, x1], axis=1),
        np.concatenate([u, u]),
        np.concatenate([mode.s, mode.s], axis=1),
        np.concatenate([t, t + h]),
        theta,
        twice,
        columns,
    )
    f0, f1, a0, a1 = ends.f[:, :n], ends.f[:, n:], ends.A[:, :, :n], ends.A[:, :, n:]
    middle = joint.evaluate((x0 + x1) / 2 + h / 8 * (f0 - f1), u, mode.s, t + h / 2, theta, mode.locked, columns)
    am, eye = middle.A, np.eye(joint.nx)[:, :, None]
    right = eye - h / 6 * (a1 + 2 * am) + h**2 / 12 * product(am, a1)
    left = eye + h / 6 * (a0 + 2 * am) + h**2 / 12 * product(am, a0)
    defect = x1 - x0 - h / 6 * (f0 + 4 * middle.f + f1)
    columns_of = [left, -defect[:, None]]
    if middle.B is not None and ends.B is not None:
        b0, b1 = ends.B[:, :, :n], ends.B[:, :, n:]
        columns_of.append(h / 6 * (b0 + 4 * middle.B + b1) + h**2 / 12 * product(am, b0 - b1))
    solved = solve(right, np.concatenate(columns_of, axis=1))
    nx = joint.nx
    return Steps(solved[:, :nx], solved[:, nx], solved[:, nx + 1 :] if len(columns_of) == 3 else None, f1)


def cross(
    motive: Motive, where: Index, x0: Array, x1: Array, reached: Array, mode: Mode, first: Index, share: Array
) -> Steps:
    """Steps in which coordinate `first` (m,) comes to rest at about `share` (m,) of the interval, from x0 (nx, m).

    reached : where the step would end without the crossing. The returned c leads to the exact end from x0.
    """
    joint, every = motive.joint, np.arange(where.size)
    h, t, row = motive.h[where], motive.t[where], joint.speeds.start + first
    z = x0 + share * (reached - x0)
    for _ in range(CROSSING_ITERATIONS):
        before = motive.part(where, share * h, t)
        step = regular(before, x0, z, mode)
        z = z + step.c
        slope = h * step.end[row, every]
        late = np.clip(share - z[row, every] / np.where(slope == 0.0, 1.0, slope), 0.0, 1.0) - share
        z, share = z + step.end * (h * late), share + late
        if np.abs(late).max() < CROSSING_TOLERANCE:
            break
    z[row, every] = 0.0
    after = motive.part(where, (1.0 - share) * h, t + share * h)
    follows = modes(after, z)
    end = z + after.h * joint.evaluate(z, after.u, follows.s, after.t, motive.theta, follows.locked).f
    for _ in range(CROSSING_ITERATIONS):
        rest = regular(after, z, end, follows)
        end = end + rest.c
        if np.abs(rest.c).max() <= CROSSING_TOLERANCE * np.abs(end).max():
            break
    return _chain(step, rest, row, end - x1)


def _chain(before: Steps, after: Steps, row: Index, c: Array) -> Steps:
    """Derivatives of two steps in a row whose border moves so that state `row` (m,) is zero there."""
    every = np.arange(len(row))
    start = before.G if before.S is None else np.concatenate([before.G, before.S], axis=1)
    slope = before.end[row, every]
    slope = np.where(slope == 0.0, 1.0, slope)
    moves = -start[row, :, every].T / slope
    border = start + before.end[:, None] * moves[None]
    border[row, :, every] = 0.0
    total = product(after.G, border) - after.end[:, None] * moves[None]
    nx = len(before.G)
    if before.S is None or after.S is None:
        return Steps(total, c, None, after.end)
    return Steps(total[:, :nx], c, total[:, nx:] + after.S, after.end)
