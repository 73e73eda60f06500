"""Hermite-Simpson steps (Lobatto IIIA, order 4; Hairer & Wanner 1996, table IV.5.7) in one mode from start to end."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array
from robotid.model.linear_algebra import product, solve
from robotid.simulation.friction.mode import FrictionMode
from robotid.simulation.friction.step import StepInputs, Steps


def regular_steps(inputs: StepInputs, x0: Array, x1: Array, mode: FrictionMode) -> Steps:
    """Steps linearised at nodes x0 -> x1, (nx, n) each, whose mode does not change on the way."""
    joint, h, n = inputs.joint, inputs.h, x0.shape[1]
    theta, u, t, columns = inputs.theta, inputs.u, inputs.t, inputs.columns
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
    right_sides = [_end_matrix(sixth, a0, middle.A), -defect[:, None]]
    if middle.B is not None and ends.B is not None:
        forced = slice(len(joint.positions), None)  # no parameter acts on the positions but through the speeds
        b0, bm, b1 = ends.B[forced, :, :n], middle.B[forced], ends.B[forced, :, n:]
        right_sides.append(_forcing(sixth, b0, bm, b1, middle.A[:, forced], forced))
    solved = solve(_end_matrix(-sixth, a1, middle.A), *right_sides)
    nx = joint.nx
    return Steps(solved[:, :nx], solved[:, nx], solved[:, nx + 1 :] if len(right_sides) == 3 else None, f1)


def _end_matrix(step: Array, a: Array, am: Array) -> Array:
    """1 + step (a + 2 am) + 3 step^2 am a, (nx, nx, n): the factor of one end. In place: memory is what it costs."""
    matrix = product(am, a)
    matrix *= 3 * step
    matrix += a
    matrix += am
    matrix += am
    matrix *= step
    for i in range(len(matrix)):
        matrix[i, i] += 1.0
    return matrix


def _forcing(sixth: Array, b0: Array, bm: Array, b1: Array, am: Array, forced: slice) -> Array:
    """h / 6 (b0 + 4 bm + b1) + h^2 / 12 am (b0 - b1), (nx, k + 1, n), where the b have the rows `forced` alone."""
    forcing = product(am, b0 - b1)
    forcing *= 3 * sixth
    added = forcing[forced]
    added += b0
    added += b1
    added += 4 * bm
    forcing *= sixth
    return forcing
