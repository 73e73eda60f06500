"""All steps of one record linearised at nodes that need not be a simulation yet.

With the nodes x[n] and the unknowns z (parameters and first states), a step leads from node n to

    x[n+1] + c[n] + G[n] dx[n] + S[n] dz,

so the changes of the nodes that make them a simulation to first order are linear in dz:

    dx[n+1] = G[n] dx[n] + c[n] + S[n] dz,      dx = correction + derivatives dz.

One block bidiagonal solve with 1 + m right-hand sides gives the correction and the derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.residual import OutputError, output_columns, output_rows
from robotid.interrupt import check
from robotid.model.array import Array, Index
from robotid.model.derivatives import DerivativeColumns
from robotid.signals.record import Record
from robotid.signals.torque_steps import TorqueColumn, in_a_row
from robotid.simulation.actuator import ActingTorque, acting_torque, torque_columns, torque_response
from robotid.simulation.friction.crossing import linearise_steps
from robotid.simulation.friction.step import StepInputs
from robotid.simulation.newton.block_bidiagonal import solve_block_bidiagonal
from robotid.simulation.newton.problem import Problem
from robotid.simulation.newton.solver import state_scale
from robotid.simulation.simulate import trajectory_of
from robotid.simulation.trajectory import BLOCK, Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Linearisation:
    """One record of n samples at its nodes.

    trajectory : of the nodes as they are; changes : of the nodes, (1 + m, n, nx), the correction first; where (m,) :
    the unknowns concerned. Weighted and whitened, of the output: residual (n,) once the nodes are corrected, correction
    (n,), derivatives (m, n) of the residual.
    """

    trajectory: Trajectory
    changes: Array
    where: Index
    residual: Array
    correction: Array
    derivatives: Array

    def moved(self, step: Array) -> Array:
        """Changes of the nodes, (nx, n), for a step (m,) of the unknowns."""
        return np.asarray(np.einsum("k,knx->xn", np.concatenate([[1.0], step]), self.changes))

    @property
    def correction_of_nodes(self) -> Array:
        """What makes the nodes a simulation to first order, (nx, n)."""
        return np.asarray(self.changes[0].T)


@np.errstate(all="ignore")  # what is not finite is an error below
def linearise_records(problem: OutputError, unknowns: Array, nodes: Sequence[Array]) -> list[Linearisation]:
    """All records at their nodes, (nx, n) each. Raises NumericsError where one is not finite.

    Steps of all records are linearised together, block by block of samples: the more crossings there are in a block,
    the less each costs. Where parameters or companions differ between the records, it is one record after the other.
    """
    every = range(len(problem.records))
    groups = [[k] for k in every] if problem.joint.depends_on_record else [list(every)]
    segments = [_Segment.of(problem, k, unknowns, x) for k, x in enumerate(nodes)]
    found = [part for group in groups for part in _changes(problem, [segments[k] for k in group])]
    return [
        _shown(problem, k, segment, changes) for k, (segment, changes) in enumerate(zip(segments, found, strict=True))
    ]


@dataclass(frozen=True, slots=True, eq=False)
class _Segment:
    """A record with its parameters theta (p,), acting torque and nodes x (nx, n). first (nx,) : correction of its first
    node; channel : derivatives of the torque to channels' parameters."""

    record: Record
    theta: Array
    torque: ActingTorque
    x: Array
    first: Array
    channel: dict[int, TorqueColumn]

    @classmethod
    def of(cls, problem: OutputError, k: int, unknowns: Array, x: Array) -> _Segment:
        record = problem.records[k]
        joint = problem.joint.along(record)
        theta = joint.in_record(problem.theta(unknowns), record.name)
        torque, channel = acting_torque(joint, theta, record), torque_columns(joint, theta, record)
        return cls(record, theta, torque, x, problem.first_state(unknowns, k) - x[:, 0], channel)


def _shown(problem: OutputError, k: int, segment: _Segment, changes: Array) -> Linearisation:
    """What the changes of a record's nodes do to its output."""
    record = segment.record
    shown = list(output_rows(problem.joint, problem.output, record.speed_origin))
    joint = problem.joint.along(record)
    u, h = segment.torque.mean[:-1], record.sampling_time
    nodes = Problem(joint, segment.theta, u, h, segment.x, begin=record.begin)
    trajectory = trajectory_of(nodes, segment.torque, record, segment.x)
    inner = np.stack([np.concatenate([changes[1:, :, row], changes[:1, :, row]]) for row in shown])
    outer = problem.shaped(k, output_columns(trajectory, problem.output, problem.columns, inner))
    if not np.isfinite(outer).all():
        what = f"the derivatives on {record.name} are not finite"
        raise NumericsError(what, hint="check the parameters' guesses and bounds")
    residual = problem.residual(k, trajectory)
    return Linearisation(trajectory, changes, problem.unknowns_of(k), residual - outer[-1], outer[-1], -outer[:-1])


def _changes(problem: OutputError, segments: Sequence[_Segment]) -> list[Array]:
    """Changes of the nodes of records that share their parameters, (1 + m, n, nx) each.

    The records' nodes stand in one row. The step from the last node of one leads to the first of the next whatever came
    before, so what its interval yields does not count.
    """
    joint, columns = problem.joint.along(segments[0].record), problem.columns
    theta, name = segments[0].theta, segments[0].record.name
    moved = joint.sources(columns, name)
    mechanical = list(dict.fromkeys(c for c in moved if c is not None and c < joint.n_theta))
    width, own = 1 + len(columns) + len(problem.free_states), 1 + len(columns) + np.arange(len(problem.free_states))
    ends = np.cumsum([len(s.record) for s in segments])
    borders, begins = ends[:-1] - 1, np.zeros((len(segments), joint.nx, width))
    for begin, segment in zip(begins, segments, strict=True):
        begin[:, 0] = segment.first
        begin[list(problem.free_states), own] = 1.0
    x = np.concatenate([s.x for s in segments], axis=1)
    starts, stops = x[:, :-1].copy(), x[:, 1:]
    starts[:, borders] = stops[:, borders]
    u, t = np.concatenate([s.torque.mean for s in segments])[:-1], np.concatenate([s.record.t for s in segments])[:-1]
    lengths = np.repeat([s.record.sampling_time for s in segments], [len(s.record) for s in segments])[:-1]
    within = in_a_row([(s.torque.steps, len(s.record)) for s in segments])
    same = float(lengths[0]) if np.all(lengths == lengths[0]) else None  # what is the same throughout costs less
    channel = {c: TorqueColumn.in_a_row([s.channel[c] for s in segments]) for c in segments[0].channel}
    found, begin = np.empty((width, x.shape[1], joint.nx)), begins[0]
    found[:, 0] = begin.T
    for first in range(0, len(u), BLOCK):
        check()
        last = min(len(u), first + BLOCK)
        block = slice(first, last)
        h = lengths[block] if same is None else same
        inner = None if within is None else within.take(block)
        inputs = StepInputs(
            joint, theta, u[block], t[block], h, DerivativeColumns(tuple(mechanical)), torque_steps=inner
        )
        steps = linearise_steps(inputs, starts[:, block], stops[:, block])
        assert steps.S is not None
        forcing = np.zeros((width, last - first + 1, joint.nx)).transpose(2, 0, 1)
        forcing[:, :, 0], forcing[:, 0, 1:] = begin, steps.c
        for i, column in enumerate(moved, start=1):
            if column is None:
                continue
            if column < joint.n_theta:
                forcing[:, i, 1:] = steps.S[:, mechanical.index(column)]
            elif column in channel:
                forcing[:, i, 1:] = torque_response(steps, channel[column], block)
        for k in np.flatnonzero((borders >= first) & (borders < last)):
            steps.G[:, :, borders[k] - first] = 0.0
            forcing[:, :, borders[k] - first + 1] = begins[k + 1]
        solved = solve_block_bidiagonal(steps.G, forcing).transpose(1, 2, 0)
        found[:, first + 1 : last + 1] = solved[:, 1:]
        begin = solved[:, -1].T
    return np.split(found, ends[:-1], axis=1)


def largest_change(x: Array, change: Array) -> float:
    """Largest change of a node, of the largest value of its state; x and change (nx, n)."""
    return float((np.abs(change).max(axis=1) / state_scale(x)).max())


def moved_nodes(problem: OutputError, x: Array, change: Array) -> Array:
    """Nodes x (nx, n) after their change (nx, n), memory within its limits. A speed that would reverse under dry
    friction is at rest first: the next linearisation decides by the forces whether it goes on."""
    joint = problem.joint
    after = np.asarray(x + change)
    for row, limit in joint.state_limits.items():
        np.clip(after[row], -max(limit, abs(after[row, 0])), max(limit, abs(after[row, 0])), out=after[row])
    dry = [joint.speeds.start + j for j in joint.dry]
    turned = x[dry, 1:] * after[dry, 1:] < 0.0
    after[dry, 1:] = np.where(turned, 0.0, after[dry, 1:])
    return after
