"""What each candidate would add to a simulated output: one column a parameter, through the joint as it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.scoring.candidates import Candidate
from robotid.estimate.residual import output_columns, output_rows
from robotid.model.array import Array, blocks
from robotid.model.channel import Channel
from robotid.model.joint_with_candidates import JointWithCandidates
from robotid.model.port import Port, Signal
from robotid.model.port_motion import Placed
from robotid.model.term import Motion, Term
from robotid.signals.record import Quantity, Record
from robotid.simulation.friction.mode import friction_mode
from robotid.simulation.internal_states import simulate_internal_states
from robotid.simulation.sensitivities import sensitivities
from robotid.simulation.trajectory import BLOCK, Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """Derivatives of an output (n,). known (k, n) : to what was fitted; missing (q, n) : to the candidates' parameters,
    candidate by candidate; more (m, n) : to forces that were asked for."""

    known: Array
    missing: Array
    more: Array


def columns(
    trajectory: Trajectory,
    record: Record,
    output: Quantity,
    fitted: Sequence[int],
    free_states: Sequence[int],
    missing: Sequence[Candidate],
    more: Array | None = None,
) -> Columns:
    """All columns of one record in one banded solve.

    fitted : indices into theta; free_states : of the trajectory's joint; more (nv, m, n) : generalised forces [Nm],
    each held over its interval.
    """
    forces, rows = _forces(as_measured(trajectory, record), record, missing)
    if more is not None:
        forces = np.concatenate([forces, more], axis=1)
    inner = sensitivities(trajectory, record, fitted, output_rows(trajectory.joint, output), free_states, forces)
    outer = output_columns(trajectory, output, fitted, inner)
    given = len(fitted) + len(free_states)
    every = np.zeros((sum(len(c.scored) for c in missing), len(record)))
    last = forces.shape[1] - (0 if more is None else more.shape[1])
    every[rows] = outer[given : given + last]
    _add_sensors(every, with_angle(trajectory), output, missing)
    every[~np.isfinite(every).all(axis=1)] = 0.0  # memory that runs away on this motion: there is nothing to score
    return Columns(outer[:given], every, outer[given + last :])


def with_angle(trajectory: Trajectory) -> Trajectory:
    """The same trajectory of a joint that keeps its angle."""
    joint = trajectory.joint
    if joint.keeps_angle:
        return trajectory
    return replace(
        trajectory,
        joint=joint.with_more(angle=True),
        x=np.insert(trajectory.x, joint.motor_speed, trajectory.phi_m, axis=0),
    )


def as_measured(trajectory: Trajectory, record: Record) -> Trajectory:
    """The same trajectory at the measured angle: there the torques of the machine acted, while a simulated angle drifts
    with all that the model lacks."""
    kept = with_angle(trajectory)
    x = kept.x.copy()
    x[kept.joint.motor_angle] = record.phi_m
    return replace(kept, x=x, phi_m=record.phi_m)


def _forces(trajectory: Trajectory, record: Record, missing: Sequence[Candidate]) -> tuple[Array, list[int]]:
    """Mean generalised forces (nv, q, n) of all candidates that act on the joint, and which columns they are."""
    joint, n = trajectory.joint, len(record)
    first = np.cumsum([0, *(len(c.scored) for c in missing)])
    terms = [(k, c) for k, c in enumerate(missing) if isinstance(c.effect, Term)]
    means = _term_forces(trajectory, [c for _, c in terms])
    rows = [int(first[k]) + i for k, c in terms for i in range(len(c.scored))]
    torques = []
    for k, c in enumerate(missing):
        if isinstance(c.effect, Channel) and c.place is Signal.TORQUE:
            torques += list(c.effect.partials(trajectory.u, record.sampling_time, c.values)[list(c.scored)])
            rows += range(int(first[k]), int(first[k + 1]))
    extra = np.zeros((joint.masses, len(torques), n))
    if torques:
        extra[0] = torques
    return np.concatenate([means, extra], axis=1), rows


def _term_forces(trajectory: Trajectory, missing: Sequence[Candidate]) -> Array:
    """Mean generalised forces in the intervals, (nv, q, n), of the parameters that are scored; zero after the last
    sample."""
    base, (joint, theta) = trajectory.joint, _lacking(trajectory, missing)
    wanted = [
        place.at.start - len(base.names) + k
        for place, c in zip(joint.candidates, missing, strict=True)
        for k in c.scored
    ]
    n, t = len(trajectory.u), trajectory.t
    memory = _memory(trajectory, [c for c in missing if isinstance(c.effect, Term) and c.effect.states])
    forces = np.zeros((joint.masses, len(wanted), n))
    for interval in blocks(n - 1, BLOCK):
        at = slice(interval.start, interval.stop + 1)
        x = np.concatenate([trajectory.x[:, at], memory[:, at]])
        s = friction_mode(trajectory.step_inputs(at), trajectory.x[:, at]).s
        forces[:, :, interval] = joint.candidate_forces(x, s, t[at], theta)[:, wanted]
    return forces


def felt(trajectory: Trajectory, missing: Sequence[Candidate]) -> tuple[tuple[Placed, ...], list[Motion]]:
    """Where candidates that are terms act, and what they feel along a trajectory of a joint that keeps its angle."""
    joint, theta = _lacking(trajectory, missing)
    x = trajectory.x
    return joint.candidates, joint.candidate_motions(x, np.sign(x[joint.speeds]), trajectory.t, theta)


def _lacking(trajectory: Trajectory, missing: Sequence[Candidate]) -> tuple[JointWithCandidates, Array]:
    """The trajectory's joint with the candidates that it lacks, and all its parameters."""
    placed = [(Port(str(c.place)), c.effect) for c in missing if isinstance(c.effect, Term)]
    theta = np.concatenate([trajectory.theta, *(np.array(c.values) for c in missing)])
    return JointWithCandidates(trajectory.joint, placed), theta


def _memory(trajectory: Trajectory, missing: Sequence[Candidate]) -> Array:
    """States of candidates with memory, as the trajectory drives them, (rows, n)."""
    cases = zip(*felt(trajectory, missing), missing, strict=True)
    rows = [simulate_internal_states(place.term, m, c.values, trajectory.sampling_time) for place, m, c in cases]
    return np.concatenate([np.zeros((0, len(trajectory.u))), *rows])


def _add_sensors(every: Array, trajectory: Trajectory, output: Quantity, missing: Sequence[Candidate]) -> None:
    """The columns of candidates that act on the measured signal itself."""
    first = 0
    for c in missing:
        last = first + len(c.scored)
        if isinstance(c.effect, Channel) and c.place is not Signal.TORQUE:
            every[first:last] = sensed(trajectory, output, c)
        first = last


def sensed(trajectory: Trajectory, output: Quantity, candidate: Candidate) -> Array:
    """Columns of a channel behind all others on a sensor, (k, n)."""
    joint = trajectory.joint
    assert isinstance(candidate.effect, Channel)
    extended = joint.with_more(channels=[(Signal(str(candidate.place)), candidate.effect)], angle=True)
    at = len(joint.names) - len(joint.changes)
    theta = np.insert(trajectory.theta, at, candidate.values)
    columns = [at + k for k in candidate.scored]
    still = np.zeros((len(output_rows(extended, output)), len(columns), len(trajectory.u)))
    return output_columns(replace(trajectory, joint=extended, theta=theta), output, columns, still)
