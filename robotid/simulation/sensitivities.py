"""Exact derivatives of a trajectory: of its states to parameters, first states and forces, and of a sum to all forces.

Both directions use the triangular system of the simulation with other right-hand sides, block by block of samples.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.interrupt import check
from robotid.model.array import Array, blocks
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.signals.record import Record
from robotid.simulation.actuator import torque_columns, torque_response
from robotid.simulation.friction.step import Steps
from robotid.simulation.newton.block_bidiagonal import solve_block_bidiagonal
from robotid.simulation.newton.chunked_responses import MANY, responses
from robotid.simulation.trajectory import BLOCK, Trajectory


def sensitivities(
    trajectory: Trajectory,
    record: Record,
    columns: Sequence[int],
    rows: Sequence[int],
    free_states: Sequence[int] = (),
    forces: Array | None = None,
    steps: Steps | None = None,
) -> Array:
    """Derivatives of states `rows` to k unknowns, (rows, k, n).

    The unknowns are the parameters `columns` of theta, the first values of the states `free_states`, and the size of
    each of `forces` (nv, q, n), generalised forces on the coordinates that are constant in their intervals. record :
    the one that was simulated; steps : of all intervals, with the derivatives to `wanted_columns`, where they are known
    already. Only the wanted rows are kept, so that memory grows with these alone.
    """
    n, pushes = len(trajectory.u), 0 if forces is None else forces.shape[1]
    out = np.empty((len(rows), len(columns) + len(free_states) + pushes, n))
    for at, found in sensitivity_blocks(trajectory, record, columns, rows, free_states, forces, steps):
        out[:, :, at] = found
    return out


def sensitivity_blocks(
    trajectory: Trajectory,
    record: Record,
    columns: Sequence[int],
    rows: Sequence[int],
    free_states: Sequence[int] = (),
    forces: Array | None = None,
    known: Steps | None = None,
) -> Iterator[tuple[slice, Array]]:
    """What `sensitivities` returns, block by block of samples, so that memory does not grow with the record."""
    joint, n = trajectory.joint, len(trajectory.u)
    forces = np.zeros((joint.masses, 0, n)) if forces is None else forces
    moved = joint.sources(columns, record.name)
    wanted = wanted_columns(joint, columns, record.name, forces=forces.size > 0)
    mechanical = list(wanted.parameters)
    through_torque = torque_columns(joint, trajectory.theta, record)
    first_force, pushes = len(columns) + len(free_states), forces.shape[1]
    width = first_force + pushes
    solved = width if pushes < MANY else first_force  # one by one, the others as of `responses`
    start = np.zeros((joint.nx, width))
    start[list(free_states), len(columns) + np.arange(len(free_states))] = 1.0
    yield slice(0, 1), start[list(rows), :, None]
    buffer = np.empty(solved * (min(n - 1, BLOCK) + 1) * joint.nx)  # one for all blocks: memory afresh is slow
    for at in blocks(n - 1, BLOCK):
        check()
        steps = trajectory.linearise(at, wanted) if known is None else known.part(at)
        assert steps.S is not None
        nodes = at.stop - at.start + 1
        forcing = buffer[: solved * nodes * joint.nx].reshape(solved, nodes, joint.nx).transpose(2, 0, 1)
        forcing[:, :first_force], forcing[:, :, 0] = 0.0, start[:, :solved]
        for k, column in enumerate(moved):
            if column is None:
                continue
            if column < joint.n_theta:
                forcing[:, k, 1:] = steps.S[:, mechanical.index(column)]
            elif column in through_torque:
                forcing[:, k, 1:] = torque_response(steps, through_torque[column], at)
        to_forces, acting = steps.S[:, len(mechanical) : -1], forces[: len(wanted.forces), :, at]
        if solved == width:
            np.einsum("ijn,jqn->iqn", to_forces, acting, out=forcing[:, first_force:, 1:])
        z = solve_block_bidiagonal(steps.G, forcing)
        found = np.empty((len(rows), width, nodes - 1))
        found[:, :solved] = z[list(rows), :, 1:]
        if solved < width:
            start[:, solved:] = responses(steps.G, to_forces, acting, rows, found[:, solved:], start[:, solved:])
        start[:, :solved] = z[:, :, -1]
        yield slice(at.start + 1, at.stop + 1), found


def wanted_columns(joint: Joint, columns: Sequence[int], record: str, *, forces: bool) -> DerivativeColumns:
    """To what a record's steps are differentiated for the derivatives to the parameters `columns` of theta, and to
    forces on all coordinates."""
    sources = joint.sources(columns, record)
    mechanical = dict.fromkeys(k for k in sources if k is not None and k < joint.n_theta)  # each once
    return DerivativeColumns(tuple(mechanical), tuple(range(joint.masses)) if forces else ())


def force_gradient(trajectory: Trajectory, row: int, weights: Array) -> Array:
    """Derivative of the sum of weights (n,) times state `row` to a generalised force on each coordinate, (nv, n).

    The force is constant over the interval after its sample. One adjoint solve a block, from the last to the first.
    """
    masses = trajectory.joint.masses
    wanted, gradient = DerivativeColumns(forces=tuple(range(masses))), np.zeros((masses, len(trajectory.u)))
    for at, effects, later in _adjoint_blocks(row, weights[None], linearised(trajectory, wanted)):
        gradient[:, at] = np.einsum("ijn,in->jn", effects[:, :masses], later[:, 0])
    return gradient


@dataclass(frozen=True, slots=True, eq=False)
class LinearisedSteps:
    """What an adjoint solve asks of k intervals: G (nx, nx, k), and the derivatives S (nx, s, k) of the states at
    their ends to what is wanted and, last, to the torque."""

    at: slice
    G: Array
    S: Array


def linearised(trajectory: Trajectory, wanted: DerivativeColumns | None = None) -> Iterator[LinearisedSteps]:
    """All steps of a trajectory, block by block from the last to the first."""
    for at in reversed(list(blocks(len(trajectory.u) - 1, BLOCK))):
        check()
        steps = trajectory.linearise(at, wanted or DerivativeColumns())
        assert steps.S is not None
        yield LinearisedSteps(at, steps.G, steps.S)


def torque_gradient(
    trajectory: Trajectory, row: int, weights: Array, known: Sequence[LinearisedSteps] | None = None
) -> Array:
    """Derivatives of the sums of weights (m, n) times state `row` to the motor's torque in every interval, (m, n).

    known : the `linearised` steps, where several such gradients are asked of one trajectory.
    """
    gradient = np.zeros(weights.shape)
    for at, effects, later in _adjoint_blocks(row, weights, linearised(trajectory) if known is None else known):
        gradient[:, at] = np.einsum("in,imn->mn", effects[:, -1], later)
    return gradient


def _adjoint_blocks(row: int, weights: Array, steps: Iterable[LinearisedSteps]) -> Iterator[tuple[slice, Array, Array]]:
    """Intervals with S of their steps, and the derivatives of the sums (m,) to the states at the end of each, (nx, m,
    their number)."""
    after: Array | None = None
    for one in steps:
        at, d = one.at, len(one.G)
        if after is None:
            after = np.zeros((d, len(weights)))
            after[row] = weights[:, -1]
        right_side = np.zeros((d, len(weights), at.stop - at.start + 1))
        right_side[row, :, :-1] = weights[:, at]
        right_side[:, :, -1] = after
        z = solve_block_bidiagonal(one.G, right_side, adjoint=True)
        yield at, one.S, z[:, :, 1:]
        after = z[:, :, 0]
