"""Steps in which the mode changes: reversals, and edges of a term such as the end of a backlash.

Where a switching function would change its sign inside an interval, the instant is solved for, and the rest of the
interval goes on in the mode that the forces demand there (Filippov 1988). Derivatives pass through the crossing: the
instant moves with what the step starts from.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, Index
from robotid.model.linear_algebra import product
from robotid.simulation.friction.mode import FrictionMode, friction_mode
from robotid.simulation.friction.regular_step import regular_steps
from robotid.simulation.friction.step import StepInputs, Steps

MAX_CROSSINGS = 3  # in one interval
FURTHER_ITERATIONS = 1  # of a crossing after another in its interval: the iteration over the whole window goes on
MAX_ITERATIONS = 5  # of the crossing instant, and of the end that follows from it
INSTANT_TOLERANCE = 1e-3  # of the interval, before the last, quadratically convergent, correction
END_TOLERANCE = 1e-5  # of the largest state at the end, likewise


def linearise_steps(inputs: StepInputs, x0: Array, x1: Array) -> Steps:
    """All steps linearised at nodes x0 -> x1, (nx, n) each, crossings included."""
    return _advance(inputs, x0, x1, friction_mode(inputs, x0), MAX_CROSSINGS)


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """Where m steps leave their mode, to first order: row (m,) of the mode changes its sign at about share (m,) of the
    interval, near the node z (nx, m)."""

    row: Index
    share: Array
    z: Array


@dataclass(frozen=True, slots=True, eq=False)
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
    steps = regular_steps(inputs, x0, x1, mode)
    if not max_crossings or not (inputs.joint.dry or inputs.joint.edges):
        return steps
    reached = x1 + steps.c
    crosses = _switching_functions(inputs, reached, mode.s) * mode.s < 0.0
    where = np.flatnonzero(crosses.any(axis=0))
    if where.size:
        part, x0, crosses = inputs.take(where), x0[:, where], crosses[:, where]
        before, after = (_switching_functions(part, x, mode.s[:, where]) for x in (x0, reached[:, where]))
        share = np.where(crosses, before / np.where(crosses, before - after, 1.0), np.inf)
        first = np.argmin(share, axis=0)
        share = np.clip(share[first, np.arange(where.size)], 0.0, 1.0)
        crossing = Crossing(first, share, x0 + share * (reached[:, where] - x0))
        steps.put(where, _cross(part, x0, x1[:, where], mode.take(where), crossing, max_crossings - 1))
    return steps


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
    """Steps that cross one switching surface, and so many more at most.

    The returned c leads from x1 to the exact end, not only to first order.
    """
    joint, h, share, z = inputs.joint, inputs.h, crossing.share, crossing.z
    iterations = MAX_ITERATIONS if max_crossings == MAX_CROSSINGS - 1 else FURTHER_ITERATIONS
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
    end = x1
    for _ in range(iterations):
        rest = _advance(after, z, end, next_mode, max_crossings)
        end = end + rest.c
        if np.abs(rest.c).max() <= END_TOLERANCE * np.abs(end).max():
            break
    return _chain(step, rest, surface, end - x1)


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
        edges = joint.distance_slopes(x[:, at], s[:, at], inputs.t[at], inputs.theta, inputs.columns)
        value[at], slopes[:, at] = edges.value[edge, here], edges.to_states[edge, :, here].T
        if response is not None and edges.to_columns is not None:
            response[:, at] = edges.to_columns[edge, :, here].T
    return SwitchingSurface(value, slopes, response, at_rest)


def _chain(before: Steps, after: Steps, surface: SwitchingSurface, c: Array) -> Steps:
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
        return Steps(total, c, None, after.end)
    return Steps(total[:, :nx], c, total[:, nx:] + after.S, after.end)
