"""What each candidate would add to a simulated output: one column a parameter, through the joint as it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.refit.refitted_model import Unknowns
from robotid.diagnosis.scoring.candidate import EffectCandidate, columns_of, scored_parameters
from robotid.diagnosis.scoring.measured_motion import as_measured, with_angle
from robotid.estimate.residual import output_columns, output_rows
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulation.friction.step import Steps
from robotid.simulation.sensitivities import sensitivities
from robotid.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """Derivatives of an output (n,), per unit. parameters (p, n) : to the fitted parameters; first_states (s, n) : to
    the free first states; candidates (q, n) : to the candidates' scored parameters, candidate by candidate; forces
    (m, n) : to forces that were asked for."""

    parameters: Array
    first_states: Array
    candidates: Array
    forces: Array


def columns(
    trajectory: Trajectory,
    record: Record,
    unknowns: Unknowns,
    candidates: Sequence[EffectCandidate],
    forces: Array | None = None,
    steps: Steps | None = None,
) -> Columns:
    """All columns of one record in one banded solve.

    forces : (nv, m, n) generalised forces [Nm] of one's own, each constant over its interval; steps : as of
    `sensitivities`.
    """
    output, n = unknowns.output, len(record)
    groups = _groups(candidates)
    motion = as_measured(trajectory, record)
    driving = [kind.forces([candidates[k] for k in members], motion, record) for kind, members in groups.items()]
    own = np.zeros((trajectory.joint.masses, 0, n)) if forces is None else forces
    inner = sensitivities(
        trajectory,
        record,
        unknowns.parameters,
        output_rows(trajectory.joint, output, trajectory.speed_origin),
        unknowns.first_states,
        _joined([*driving, own]),
        steps,
    )
    outer = output_columns(trajectory, output, unknowns.parameters, inner)
    p, s = len(unknowns.parameters), len(unknowns.first_states)
    kept, first = with_angle(trajectory), p + s
    found = np.zeros((scored_parameters(candidates), n))
    places = list(columns_of(candidates))
    for (kind, members), driven in zip(groups.items(), driving, strict=True):
        last = first + driven.shape[1]
        rows = [row for k in members for row in range(places[k].start, places[k].stop)]
        found[rows] = kind.columns([candidates[k] for k in members], kept, output, outer[first:last])
        first = last
    found[~np.isfinite(found).all(axis=1)] = 0.0  # memory that runs away on this motion: there is nothing to score
    return Columns(outer[:p], outer[p : p + s], found, outer[first:])


def _joined(forces: Sequence[Array]) -> Array:
    """All forces (nv, k, n) beside each other; not copied where they are of one kind, for they are large."""
    some = [one for one in forces if one.shape[1]] or list(forces[:1])
    return some[0] if len(some) == 1 else np.concatenate(some, axis=1)


def _groups(candidates: Sequence[EffectCandidate]) -> dict[type[EffectCandidate], list[int]]:
    """Numbers of the candidates of each kind."""
    found: dict[type[EffectCandidate], list[int]] = {}
    for k, one in enumerate(candidates):
        found.setdefault(type(one), []).append(k)
    return found
