"""Steps in which the mode changes: reversals, and edges of a term such as the end of a backlash.

Where a switching function would change its sign inside an interval, the instant is solved for, and the rest of the
interval goes on in the mode that the forces demand there (Filippov 1988). Derivatives pass through the crossing: the
instant moves with what the step starts from.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.model.array import Array, Index, Mask, blocks, taken
from robotid.model.linear_algebra import product
from robotid.simulation.friction.mode import FrictionMode, friction_mode
from robotid.simulation.friction.regular_step import regular_steps
from robotid.simulation.friction.step import StepInputs, Steps

MAX_CROSSINGS = 3  # in one interval
FURTHER_ITERATIONS = 1  # of a crossing after another in its interval: the iteration over the whole window goes on
ROOT_ITERATIONS = 3  # of the instant as a cubic shows it
FIRST_ITERATIONS = 5  # of the first crossing in an interval
INSTANT_TOLERANCE = 1e-3  # of the interval, before the last, quadratically convergent, correction
CHANGE_ITERATIONS = 5  # of the state at which the torque changes
BLOCK_ENTRIES = 200_000  # derivatives at once: more do not stay in a processor's second cache
CHANGE_TOLERANCE = 1e-5  # of the largest state there, likewise


def linearise_steps(inputs: StepInputs, x0: Array, x1: Array) -> Steps:
    """All steps linearised at nodes x0 -> x1, (nx, n) each, crossings included."""
    linear = inputs.joint.linear_at(inputs.theta) if inputs.linear is None else inputs.linear
    prepared = replace(inputs, linear=linear, torque_steps=None)
    if inputs.torque_steps is None:
        return _advance(prepared, x0, x1, friction_mode(prepared, x0), MAX_CROSSINGS)
    steps = Steps.empty(inputs.joint.nx, inputs.width, x0.shape[1], stepped=True)
    changes = inputs.torque_steps.step != 0.0
    for at, advance in ((np.flatnonzero(~changes), _held), (np.flatnonzero(changes), _stepped)):
        if at.size:
            stepping = replace(prepared, torque_steps=inputs.torque_steps).take(at)
            steps.put(at, advance(stepping, taken(x0, at), taken(x1, at)))
    return steps


def _held(inputs: StepInputs, x0: Array, x1: Array) -> Steps:
    """Steps with a torque that is the same from start to end."""
    return _advance(inputs, x0, x1, friction_mode(inputs, x0), MAX_CROSSINGS)


def _stepped(inputs: StepInputs, x0: Array, x1: Array) -> Steps:
    """Steps with a torque that changes on the way, as two in a row; the instant does not move with the states.

    The returned c leads from x1 to the end to first order, as if the state at the change were solved for.
    """
    assert inputs.torque_steps is not None
    h, share = inputs.h, inputs.torque_steps.share
    first, then = inputs.torque_steps.around(inputs.u)
    before = replace(inputs.with_duration(share * h, inputs.t), u=first)
    after = replace(inputs.with_duration((1.0 - share) * h, inputs.t + share * h), u=then)
    mode, z = friction_mode(before, x0), x0 + share * (x1 - x0)
    for _ in range(CHANGE_ITERATIONS):
        step = _advance(before, x0, z, mode, MAX_CROSSINGS)
        z = z + step.c
        if np.all(np.abs(step.c).max(axis=1) <= CHANGE_TOLERANCE * np.abs(z).max(axis=1)):
            break
    rest = _advance(after, z, x1, friction_mode(after, z), MAX_CROSSINGS)
    start = step.G if step.S is None else np.concatenate([step.G, step.S], axis=1)
    total, nx = product(rest.G, start), len(step.G)
    if step.S is None or rest.S is None:
        return Steps(total, rest.c, None, step.start, rest.end)
    S = total[:, nx:] + rest.S
    to_step = share * rest.S[:, -1] - (1.0 - share) * total[:, -1]
    carried = product(rest.G, step.end[:, None])[:, 0]
    to_share = inputs.torque_steps.step * S[:, -1] + h * (carried - rest.end)
    return Steps(total[:, :nx], rest.c, S, step.start, rest.end, np.stack([to_step, to_share], axis=1))


@dataclass(slots=True, eq=False)
class Crossing:
    """Where m steps leave their mode, to first order: row (m,) of the mode changes its sign at about share (m,) of the
    interval, near the node z (nx, m)."""

    row: Index
    share: Array
    z: Array


@dataclass(slots=True, eq=False)
class SwitchingSurface:
    """The function that changes its sign at a crossing, of m steps.

    value : (m,); slopes : (nx, m) its derivatives to the states; response : (width, m) to the inputs' columns, or
    None; at_rest : the states (rows, steps) that are exactly zero on the surface.
    """

    value: Array
    slopes: Array
    response: Array | None
    at_rest: tuple[Index, Index]


def _advance(inputs: StepInputs, x0: Array, x1: Array, mode: FrictionMode, max_crossings: int) -> Steps:
    """Steps that start in this mode and may leave it so many times."""
    steps = _regular_steps(inputs, x0, x1, mode)
    if not max_crossings or not (inputs.joint.dry or inputs.joint.edges):
        return steps
    reached = x1 + steps.c
    crosses = _switching_functions(inputs, reached, mode.s) * mode.s < 0.0
    where = np.flatnonzero(crosses.any(axis=0))
    if where.size:
        part, now, crosses = inputs.take(where), mode.take(where), taken(crosses, where)
        way = Way(*(taken(one, where) for one in (x0, reached, steps.start, steps.end)))
        crossing = _first_crossing(part, now, way, crosses)
        steps.put(where, _cross(part, way.x0, taken(x1, where), now, crossing, max_crossings - 1))
    return steps


def _regular_steps(inputs: StepInputs, x0: Array, x1: Array, mode: FrictionMode) -> Steps:
    """Regular steps, as many at once as keep their derivatives in a processor's fast memory."""
    n = x0.shape[1]
    size = BLOCK_ENTRIES // (inputs.joint.nx * (2 * inputs.joint.nx + 1 + inputs.width))
    if n <= size:
        return regular_steps(inputs, x0, x1, mode)
    total, parts = Steps.empty(inputs.joint.nx, inputs.width, n), -(-n // size)
    for at in blocks(n, -(-n // parts)):
        total.put(at, regular_steps(inputs.take(at), x0[:, at], x1[:, at], mode.take(at)))
    return total


@dataclass(slots=True, eq=False)
class Way:
    """The way of m steps without a crossing: states x0 -> x1 and their rates f0, f1 at both ends, (nx, m) each."""

    x0: Array
    x1: Array
    f0: Array
    f1: Array

    def at(self, share: Array, h: Array | float) -> Array:
        """States at shares (m,) of the interval, (nx, m): Hermite's cubic."""
        return _cubic(share, self.x0, self.x1, h * self.f0, h * self.f1)


def _cubic(share: Array, y0: Array, y1: Array, d0: Array, d1: Array) -> Array:
    """Hermite's cubic through y0, y1 with slopes d0, d1 to the share."""
    rest = 1.0 - share
    ends = rest * rest * (1.0 + 2.0 * share) * y0 + share * share * (1.0 + 2.0 * rest) * y1
    return np.asarray(ends + share * rest * (rest * d0 - share * d1))


def _cubic_slope(share: Array, y0: Array, y1: Array, d0: Array, d1: Array) -> Array:
    """The slope of Hermite's cubic."""
    rest = 1.0 - share
    between = 6.0 * share * rest * (y1 - y0)
    return np.asarray(between + rest * (1.0 - 3.0 * share) * d0 + share * (3.0 * share - 2.0) * d1)


def _first_crossing(inputs: StepInputs, mode: FrictionMode, way: Way, crosses: Mask) -> Crossing:
    """The row of the mode that changes first, by a straight line, and where, by Hermite's cubic."""
    steps = np.arange(crosses.shape[1])
    before, after = (_switching_functions(inputs, x, mode.s) for x in (way.x0, way.x1))
    straight = np.where(crosses, before / np.where(crosses, before - after, 1.0), np.inf)
    row = np.argmin(straight, axis=0)
    share = np.clip(straight[row, steps], 0.0, 1.0)
    (start, to_start), (end, to_end) = (
        _value_and_rate(inputs, x, f, mode.s, row) for x, f in ((way.x0, way.f0), (way.x1, way.f1))
    )
    d0, d1 = inputs.h * to_start, inputs.h * to_end
    # from rest and to it again: the start is a root, and not meant
    back = (start == 0.0) & (d0 * end < 0.0)
    share = np.where(back, d0 / np.where(back, d0 - end, 1.0), share)
    for _ in range(ROOT_ITERATIONS):
        value, slope = _cubic(share, start, end, d0, d1), _cubic_slope(share, start, end, d0, d1)
        slope = slope - np.where(back, value / np.where(share == 0.0, 1.0, share), 0.0)
        share = np.clip(share - value / np.where(slope == 0.0, np.inf, slope), 0.0, 1.0)
    return Crossing(row, share, way.at(share, inputs.h))


def _value_and_rate(inputs: StepInputs, x: Array, f: Array, s: Array, row: Index) -> tuple[Array, Array]:
    """What row (m,) of the mode changes its sign with, at x (nx, m), and its rate where these have the rates f, (m,)
    each."""
    if not inputs.joint.edges:  # it is a speed, and there is no slope to multiply with
        at = inputs.joint.speeds.start + row, np.arange(len(row))
        return x[at], f[at]
    surface = _switching_surface(replace(inputs, columns=None), x, s, row)
    return surface.value, (surface.slopes * f).sum(axis=0)


def _switching_functions(inputs: StepInputs, x: Array, s: Array) -> Array:
    """What decides each row of a mode: the speed where friction is dry, the distance to an edge, (nv + edges, n)."""
    joint = inputs.joint
    speeds = np.zeros((joint.masses, x.shape[1]))
    speeds[list(joint.dry)] = x[[joint.speeds.start + j for j in joint.dry]]
    if not joint.edges:
        return speeds
    return np.concatenate([speeds, joint.distances(x, s, inputs.t, inputs.theta)])


def _cross(
    inputs: StepInputs, x0: Array, x1: Array, mode: FrictionMode, crossing: Crossing, max_crossings: int
) -> Steps:
    """Steps that cross one switching surface, and so many more at most."""
    joint, h, share, z = inputs.joint, inputs.h, crossing.share, crossing.z
    iterations = FIRST_ITERATIONS if max_crossings == MAX_CROSSINGS - 1 else FURTHER_ITERATIONS
    for _ in range(iterations):
        before = inputs.with_duration(share * h, inputs.t)
        step = regular_steps(before, x0, z, mode)
        z = z + step.c
        surface = _switching_surface(before, z, mode.s, crossing.row)
        speed = h * (surface.slopes * step.end).sum(axis=0)
        late = np.clip(share - surface.value / np.where(speed == 0.0, 1.0, speed), 0.0, 1.0) - share
        z, share = z + step.end * (h * late), share + late
        if np.abs(late).max() < INSTANT_TOLERANCE:
            break
    after = inputs.with_duration((1.0 - share) * h, inputs.t + share * h)
    z[surface.at_rest] = 0.0
    s = mode.s.copy()
    s[crossing.row, np.arange(len(crossing.row))] *= -1.0
    next_mode = friction_mode(after, z, s[joint.masses :])
    rest = _advance(after, z, x1, next_mode, max_crossings)
    return _chain(step, rest, surface)


def _switching_surface(inputs: StepInputs, x: Array, s: Array, row: Index) -> SwitchingSurface:
    """The surface on which row (m,) of the mode changes its sign, at x (nx, m)."""
    joint, m = inputs.joint, len(row)
    value, slopes = np.zeros(m), np.zeros((joint.nx, m))
    response = None if inputs.columns is None else np.zeros((inputs.columns.width, m))
    reversals = np.flatnonzero(row < joint.masses)
    at_rest = joint.speeds.start + row[reversals], reversals
    value[reversals], slopes[at_rest] = x[at_rest], 1.0
    at = np.flatnonzero(row >= joint.masses)
    if at.size:
        edge, here = row[at] - joint.masses, np.arange(at.size)
        edges = joint.distance_slopes(taken(x, at), taken(s, at), inputs.t[at], inputs.theta, inputs.columns)
        value[at], slopes[:, at] = edges.value[edge, here], edges.to_states[edge, :, here].T
        if response is not None and edges.to_columns is not None:
            response[:, at] = edges.to_columns[edge, :, here].T
    return SwitchingSurface(value, slopes, response, at_rest)


def _chain(before: Steps, after: Steps, surface: SwitchingSurface) -> Steps:
    """Derivatives of two steps in a row, between them a surface that they reach earlier or later as the start moves."""
    start = before.G if before.S is None else np.concatenate([before.G, before.S], axis=1)
    value = (surface.slopes[:, None] * start).sum(axis=0)
    if surface.response is not None:
        value[len(before.G) :] += surface.response
    speed = (surface.slopes * before.end).sum(axis=0)
    delay = -value / np.where(speed == 0.0, 1.0, speed)
    at = start + before.end[:, None] * delay[None]
    row, step = surface.at_rest
    at[row, :, step] = 0.0
    total = product(after.G, at) - after.end[:, None] * delay[None]
    nx = len(before.G)
    if before.S is None or after.S is None:
        return Steps(total, after.c, None, before.start, after.end)
    return Steps(total[:, :nx], after.c, total[:, nx:] + after.S, before.start, after.end)
