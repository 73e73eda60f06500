"""Hermite-Simpson steps (Lobatto IIIA, order 4; Hairer & Wanner 1996, table IV.5.7) in one mode from start to end."""

from __future__ import annotations

import numpy as np

from robotid.model import signal_matrix
from robotid.model.array import Array
from robotid.model.joint import Dynamics
from robotid.model.linear_algebra import eliminate, product
from robotid.model.signal_matrix import Rows
from robotid.simulation.friction.mode import FrictionMode
from robotid.simulation.friction.step import StepInputs, Steps

FEW = 200  # steps, that cost less by whole matrices than entry by entry


def regular_steps(inputs: StepInputs, x0: Array, x1: Array, mode: FrictionMode) -> Steps:
    """Steps linearised at nodes x0 -> x1, (nx, n) each, whose mode does not change on the way."""
    joint, h, n, nx = inputs.joint, inputs.h, x0.shape[1], inputs.joint.nx
    theta, u, t, columns, linear = inputs.theta, inputs.u, inputs.t, inputs.columns, inputs.linear
    still = None if mode.sticking is None else np.concatenate([mode.sticking, mode.sticking], axis=1)
    ends = joint.evaluate(
        np.concatenate([x0, x1], axis=1),
        np.concatenate([u, u]),
        np.concatenate([mode.s, mode.s], axis=1),
        np.concatenate([t, t + h]),
        theta,
        still,
        columns,
        linear,
    )
    f0, f1 = ends.f[:, :n], ends.f[:, n:]
    middle_x = (x0 + x1) / 2 + h / 8 * (f0 - f1)
    middle = joint.evaluate(middle_x, u, mode.s, t + h / 2, theta, mode.sticking, columns, linear)
    width = 0 if columns is None else columns.width
    work, sixth = np.empty((nx, 2 * nx + 1 + width, n)), h / 6
    (_put_densely if n <= FEW else _put_entries)(ends, middle, sixth, work)
    np.add(x0 - x1, sixth * (f0 + 4 * middle.f + f1), out=work[:, 2 * nx])
    solved = eliminate(work)
    return Steps(solved[:, :nx], solved[:, nx], solved[:, nx + 1 :] if width else None, f0, f1)


def _put_entries(ends: Dynamics, middle: Dynamics, sixth: Array | float, work: Array) -> None:
    """The matrices of both ends and the forcing, written to work entry by entry."""
    nx, n = len(work), work.shape[2]
    first, last = slice(n), slice(n, None)
    at_start, at_end = (signal_matrix.scale(sixth, signal_matrix.at(ends.to_states, part)) for part in (first, last))
    inner = signal_matrix.scale(sixth, middle.to_states)
    twice, thrice = signal_matrix.scale(2.0, inner), signal_matrix.scale(3.0, inner)
    _put_end_matrix(-1.0, at_end, twice, thrice, work[:, :nx])
    _put_end_matrix(1.0, at_start, twice, thrice, work[:, nx : 2 * nx])
    if ends.to_columns is not None and middle.to_columns is not None:
        b0, b1 = signal_matrix.at(ends.to_columns, first), signal_matrix.at(ends.to_columns, last)
        forcing = _forcing(sixth, b0, middle.to_columns, b1, thrice)
        signal_matrix.put(forcing, work[:, 2 * nx + 1 :])


def _put_densely(ends: Dynamics, middle: Dynamics, sixth: Array | float, work: Array) -> None:
    """The same by whole matrices, which costs less where there are few steps."""
    nx, n = len(work), work.shape[2]
    at_ends, inner = ends.A, sixth * middle.A
    start, end, thrice = sixth * at_ends[:, :, :n], sixth * at_ends[:, :, n:], 3.0 * inner
    identity = np.eye(nx)[:, :, None]
    work[:, :nx] = identity - end - 2.0 * inner + product(thrice, end)
    work[:, nx : 2 * nx] = identity + start + 2.0 * inner + product(thrice, start)
    to_ends, to_middle = ends.B, middle.B
    if to_ends is not None and to_middle is not None:
        b0, b1 = to_ends[:, :, :n], to_ends[:, :, n:]
        work[:, 2 * nx + 1 :] = sixth * (b0 + 4.0 * to_middle + b1 + product(thrice, b0 - b1))


def _put_end_matrix(sign: float, a: Rows, twice_am: Rows, thrice_am: Rows, out: Array) -> None:
    """1 + sign (a + 2 am) + 3 am a, (nx, nx, n), a and am times h / 6: the factor of one end, written to out."""
    matrix = signal_matrix.multiply(thrice_am, a)
    signal_matrix.add(matrix, a, sign)
    signal_matrix.add(matrix, twice_am, sign)
    signal_matrix.put(matrix, out)
    for i in range(len(out)):
        out[i, i] += 1.0


def _forcing(sixth: Array | float, b0: Rows, bm: Rows, b1: Rows, thrice_am: Rows) -> Rows:
    """h / 6 (b0 + 4 bm + b1) + h / 2 am (b0 - b1), (nx, width), am times h / 6."""
    difference: Rows = [dict(row) for row in b0]
    signal_matrix.add(difference, b1, -1.0)
    forcing = signal_matrix.multiply(thrice_am, difference)
    for part, factor in ((b0, 1.0), (b1, 1.0), (bm, 4.0)):
        signal_matrix.add(forcing, part, factor)
    return signal_matrix.scale(sixth, forcing)
