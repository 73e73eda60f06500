"""One implicit step for every sampling interval at once, with dry friction exact inside the step.

Regular steps are Hermite-Simpson (Lobatto IIIA, order 4; Hairer & Wanner 1996, table IV.5.7), one residual an
interval. Coulomb friction is set-valued, sgn(0) = [-1, 1]: a coordinate slips one way, the other way, or rests while
the friction it needs is within its level. Where the speed would cross zero inside an interval, the crossing instant
is solved for, and the rest of the interval goes on in the mode that the forces demand (Filippov 1988); likewise where
the motion crosses an edge of a term, such as the end of a backlash. Derivatives pass through the crossing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, Index, Mask
from robotid.model.joint import Joint
from robotid.model.linear_algebra import product, solve

CROSSING_ITERATIONS = 5
MOST_CROSSINGS = 3  # in one interval
INSTANT_TOLERANCE = 1e-3  # of the interval, before the last, quadratically convergent, correction
CROSSING_TOLERANCE = 1e-5  # of where it ends, likewise


@dataclass(slots=True)
class Steps:
    """Linearised steps x[n+1] = x1[n] + c + G (x[n] - x0[n]) + S dtheta.

    G (nx, nx, n), c (nx, n), S (nx, k + 1, n) or None, end : (nx, n) rate of the states where each step ends.
    The last column of S is the derivative to the torque, constant over the interval.
    """

    G: Array
    c: Array
    S: Array | None
    end: Array

    def put(self, where: Index, other: Steps) -> None:
        """Replace the steps at these indices."""
        self.G[:, :, where], self.c[:, where], self.end[:, where] = other.G, other.c, other.end
        if self.S is not None and other.S is not None:
            self.S[:, :, where] = other.S


@dataclass(slots=True)
class StepInputs:
    """What acts during n steps: torque u, start times t, lengths h, each (n,), theta, and derivative columns wanted."""

    joint: Joint
    theta: Array
    u: Array
    t: Array
    h: Array
    columns: Sequence[int] | None = None

    def part(self, where: Index) -> StepInputs:
        """The steps at these indices."""
        return StepInputs(self.joint, self.theta, self.u[where], self.t[where], self.h[where], self.columns)

    def with_duration(self, h: Array, t: Array) -> StepInputs:
        """The same steps with other lengths and start times."""
        return StepInputs(self.joint, self.theta, self.u, t, h, self.columns)


@dataclass(slots=True)
class Mode:
    """Directions of motion and sides of edges s (nv + edges, n), and which coordinates friction holds at rest (nv, n),
    None where none is."""

    s: Array
    sticking: Mask | None

    def part(self, where: Index) -> Mode:
        return Mode(self.s[:, where], None if self.sticking is None else self.sticking[:, where])


def modes(motive: StepInputs, x: Array, sides: Array | None = None) -> Mode:
    """Slip one way, the other, or rest, for states x (nx, n) at the start of their steps. sides : (edges, n), where
    they are known already."""
    joint = motive.joint
    s = np.sign(x[joint.speeds])
    s = joint.directions(x, s, motive.t, motive.theta) if sides is None else np.concatenate([s, sides])
    sticking = np.zeros((joint.masses, s.shape[1]), dtype=bool)
    for j in joint.dry:
        still = np.flatnonzero(s[j] == 0.0)
        if still.size:
            s[j, still], sticking[j, still] = _break_away(motive, x, s, j, still)
    return Mode(s, sticking if sticking.any() else None)


def _break_away(motive: StepInputs, x: Array, s: Array, j: int, still: Index) -> tuple[Array, Mask]:
    twice, both = np.tile(still, 2), np.repeat([1.0, -1.0], still.size)
    trial = s[:, twice]
    trial[j] = both
    pull = motive.joint.force(x[:, twice], motive.u[twice], trial, motive.t[twice], motive.theta)[j]
    ahead, back = np.split(pull, 2)
    return np.where(ahead > 0.0, 1.0, np.where(back < 0.0, -1.0, 0.0)), (ahead <= 0.0) & (back >= 0.0)


def linearise(motive: StepInputs, x0: Array, x1: Array) -> Steps:
    """All steps at the trajectory x0 (nx, n) -> x1 (nx, n), crossings included."""
    return _advance(motive, x0, x1, modes(motive, x0), MOST_CROSSINGS)


def _advance(motive: StepInputs, x0: Array, x1: Array, mode: Mode, crossings: int) -> Steps:
    """Steps that start in this mode and may cross so many times."""
    steps = regular(motive, x0, x1, mode)
    if not crossings or not (motive.joint.dry or motive.joint.edges):
        return steps
    reached = x1 + steps.c
    crossing = _signed(motive, reached, mode.s) * mode.s < 0.0
    where = np.flatnonzero(crossing.any(axis=0))
    if where.size:
        part, x0, crossing = motive.part(where), x0[:, where], crossing[:, where]
        before, after = (_signed(part, x, mode.s[:, where]) for x in (x0, reached[:, where]))
        share = np.where(crossing, before / np.where(crossing, before - after, 1.0), np.inf)
        first = np.argmin(share, axis=0)
        share = np.clip(share[first, np.arange(where.size)], 0.0, 1.0)
        z = x0 + share * (reached[:, where] - x0)
        steps.put(where, cross(part, x0, x1[:, where], z, mode.part(where), first, share, crossings - 1))
    return steps


def _signed(motive: StepInputs, x: Array, s: Array) -> Array:
    """What decides each row of a mode: the speed where friction is dry, the distance to an edge, (nv + edges, n)."""
    joint = motive.joint
    speeds = np.zeros((joint.masses, x.shape[1]))
    speeds[list(joint.dry)] = x[[joint.speeds.start + j for j in joint.dry]]
    if not joint.edges:
        return speeds
    return np.concatenate([speeds, joint.distances(x, s, motive.t, motive.theta)])


def regular(motive: StepInputs, x0: Array, x1: Array, mode: Mode) -> Steps:
    """Hermite-Simpson steps in a given mode."""
    joint, h, n = motive.joint, motive.h, x0.shape[1]
    theta, u, t, columns = motive.theta, motive.u, motive.t, motive.columns
    twice = None if mode.sticking is None else np.concatenate([mode.sticking, mode.sticking], axis=1)
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
    middle = joint.evaluate((x0 + x1) / 2 + h / 8 * (f0 - f1), u, mode.s, t + h / 2, theta, mode.sticking, columns)
    sixth = h / 6
    defect = x1 - x0 - sixth * (f0 + 4 * middle.f + f1)
    columns_of = [_side(sixth, a0, middle.A), -defect[:, None]]
    if middle.B is not None and ends.B is not None:
        forced = slice(len(joint.positions), None)  # no parameter acts on the positions but through the speeds
        b0, bm, b1 = ends.B[forced, :, :n], middle.B[forced], ends.B[forced, :, n:]
        columns_of.append(_forcing(sixth, b0, bm, b1, middle.A[:, forced], forced))
    solved = solve(_side(-sixth, a1, middle.A), *columns_of)
    nx = joint.nx
    return Steps(solved[:, :nx], solved[:, nx], solved[:, nx + 1 :] if len(columns_of) == 3 else None, f1)


def _side(step: Array, a: Array, am: Array) -> Array:
    """1 + step (a + 2 am) + 3 step^2 am a, (nx, nx, n): what multiplies one end. In place: memory is what it costs."""
    side = product(am, a)
    side *= 3 * step
    side += a
    side += am
    side += am
    side *= step
    for i in range(len(side)):
        side[i, i] += 1.0
    return side


def _forcing(sixth: Array, b0: Array, bm: Array, b1: Array, am: Array, forced: slice) -> Array:
    """h / 6 (b0 + 4 bm + b1) + h^2 / 12 am (b0 - b1), (nx, k + 1, n), where the b have the rows `forced` alone."""
    forcing = product(am, b0 - b1)
    forcing *= 3 * sixth
    moved = forcing[forced]
    moved += b0
    moved += b1
    moved += 4 * bm
    forcing *= sixth
    return forcing


def cross(
    motive: StepInputs, x0: Array, x1: Array, z: Array, mode: Mode, first: Index, share: Array, crossings: int
) -> Steps:
    """Steps in which row `first` (m,) of the mode changes sign at about `share` (m,) of the interval, near z (nx, m).

    The returned c leads from x1 to the exact end, not only to first order; crossings : how many more may follow.
    """
    joint, h = motive.joint, motive.h
    for _ in range(CROSSING_ITERATIONS):
        before = motive.with_duration(share * h, motive.t)
        step = regular(before, x0, z, mode)
        z = z + step.c
        border = _border(before, z, mode.s, first)
        speed = h * (border.slopes * step.end).sum(axis=0)
        late = np.clip(share - border.value / np.where(speed == 0.0, 1.0, speed), 0.0, 1.0) - share
        z, share = z + step.end * (h * late), share + late
        if np.abs(late).max() < INSTANT_TOLERANCE:
            break
    after = motive.with_duration((1.0 - share) * h, motive.t + share * h)
    z[border.stops] = 0.0
    s = mode.s.copy()
    s[first, np.arange(len(first))] *= -1.0
    follows = modes(after, z, s[joint.masses :])
    end = x1
    for _ in range(CROSSING_ITERATIONS):
        rest = _advance(after, z, end, follows, crossings)
        end = end + rest.c
        if np.abs(rest.c).max() <= CROSSING_TOLERANCE * np.abs(end).max():
            break
    return _chain(step, rest, border, end - x1)


@dataclass(slots=True)
class SwitchingSurface:
    """What changes sign in a crossing, for m steps: its value (m,), its slopes to the states (nx, m), its response to
    theta[columns] and u (k + 1, m) or None; stops : the states (row, step) that are exactly zero there."""

    value: Array
    slopes: Array
    response: Array | None
    stops: tuple[Index, Index]


def _border(motive: StepInputs, x: Array, s: Array, row: Index) -> SwitchingSurface:
    """The border that row (m,) of the mode is about, at x (nx, m)."""
    joint, m = motive.joint, len(row)
    value, slopes = np.zeros(m), np.zeros((joint.nx, m))
    response = None if motive.columns is None else np.zeros((len(motive.columns) + 1, m))
    still = np.flatnonzero(row < joint.masses)
    stops = joint.speeds.start + row[still], still
    value[still], slopes[stops] = x[stops], 1.0
    at = np.flatnonzero(row >= joint.masses)
    if at.size:
        edge, here = row[at] - joint.masses, np.arange(at.size)
        d, to_x, to_theta = joint.distance_slopes(x[:, at], s[:, at], motive.t[at], motive.theta, motive.columns)
        value[at], slopes[:, at] = d[edge, here], to_x[edge, :, here].T
        if response is not None and to_theta is not None:
            response[:, at] = to_theta[edge, :, here].T
    return SwitchingSurface(value, slopes, response, stops)


def _chain(before: Steps, after: Steps, border: SwitchingSurface, c: Array) -> Steps:
    """Derivatives of two steps in a row whose border moves with what the first one starts from."""
    start = before.G if before.S is None else np.concatenate([before.G, before.S], axis=1)
    value = (border.slopes[:, None] * start).sum(axis=0)
    if border.response is not None:
        value[len(before.G) :] += border.response
    speed = (border.slopes * before.end).sum(axis=0)
    moves = -value / np.where(speed == 0.0, 1.0, speed)
    at = start + before.end[:, None] * moves[None]
    row, step = border.stops
    at[row, :, step] = 0.0
    total = product(after.G, at) - after.end[:, None] * moves[None]
    nx = len(before.G)
    if before.S is None or after.S is None:
        return Steps(total, c, None, after.end)
    return Steps(total[:, :nx], c, total[:, nx:] + after.S, after.end)
