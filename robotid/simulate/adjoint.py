"""Derivatives the other way round: of one number that an output makes, to a force at every sample."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulate.friction.steps import linearise
from robotid.simulate.newton.solver import Problem, solve_block_bidiagonal
from robotid.simulate.simulate import BLOCK, Trajectory


def force_gradient(trajectory: Trajectory, record: Record, row: int, weights: Array) -> Array:
    """Derivative of the sum of weights (n,) times state `row` to a generalised force on each coordinate, held over the
    interval after each sample, (nv, n). One adjoint solve a block, from the last to the first."""
    joint, n = trajectory.joint, len(trajectory.u)
    problem = Problem(
        joint, trajectory.theta, trajectory.u[:-1], trajectory.sampling_time, trajectory.x, begin=record.begin
    )
    found, after = np.zeros((joint.masses, n)), np.zeros(joint.nx)
    after[row] = weights[-1]
    for first in reversed(range(0, n - 1, BLOCK)):
        last = min(n - 1, first + BLOCK)
        motive = problem.motive(first, last, [-1 - j for j in range(joint.masses)])
        steps = linearise(motive, trajectory.x[:, first:last], trajectory.x[:, first + 1 : last + 1])
        assert steps.S is not None
        goal = np.zeros((joint.nx, 1, last - first + 1))
        goal[row, 0, :-1] = weights[first:last]
        goal[:, 0, -1] = after
        z = solve_block_bidiagonal(steps, goal, back=True)[:, 0]
        found[:, first:last] = np.einsum("ijn,in->jn", steps.S[:, : joint.masses], z[:, 1:])
        after = z[:, 0]
    return found
