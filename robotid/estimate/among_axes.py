"""The response of one axis to its own torque while the motors of the others stand, from experiments in which all move.

Experiments with orthogonal phases, as many as axes, give the matrix G of responses from all torques to all
accelerations. That of an axis by itself is 1 / (G^-1)_kk: its notch is the resonance of its own gear and arm. It does
not depend on the units, filters and delays of what is recorded of the other axes, which scale rows and columns of G
that (G^-1)_kk has no part in: their angles may be those behind the gears, their torques of any scale.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.responses import Response, nonlinear_torque
from robotid.model.array import Array
from robotid.model.companion import CompanionKind, drive_of
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.signals.differentiate import central_difference
from robotid.signals.frf_matrix import estimate_frf_matrix, log_mean
from robotid.signals.record import Record

OWN = ""


def response_among_axes(
    joint: Joint,
    parameters: Parameters,
    groups: Sequence[Sequence[Record]],
    band: tuple[float, float] | None = None,
) -> Response:
    """One response from groups of experiments, each with as many records as axes, all of the same lines: the mean of
    the logarithm over groups, in other poses or with phases drawn anew.

    The nonlinear friction of the joint, with the values of `parameters`, is taken off its torque, that of the other
    axes by regression. Raises NumericsError where the records lack an axis, do not tell the axes apart, or do not
    repeat, so that nothing tells how certain they are.
    """
    matrices = []
    for group in groups:
        experiments = [_by_axis(record, record.tau_m - nonlinear_torque(joint, parameters, record)) for record in group]
        matrices.append(estimate_frf_matrix(experiments, band))
    records = tuple(record for group in groups for record in group)
    remark = f"the motors of {', '.join(_others(records[0]))} standing, from {_count(len(groups), len(groups[0]))}"
    frf = log_mean(matrices).alone(OWN)
    if not np.isfinite(frf.std).all():
        what = "one period of each experiment does not tell how certain the responses are"
        raise NumericsError(what, where=records[0].name, hint="play three periods, or draw the phases anew")
    return Response(replace(frf, record="+".join(r.name for r in records), remarks=(remark,)), records)


def _others(record: Record) -> list[str]:
    """The other axes whose angle and torque a record has."""
    companions = record.companions
    return [
        name for name, one in companions.items() if one.kind is CompanionKind.ANGLE and drive_of(name) in companions
    ]


def _by_axis(record: Record, torque: Array) -> Mapping[str, Record]:
    """A record of each axis. torque (n,) : of its own axis, dry friction taken off."""
    others, h = _others(record), record.sampling_time
    if not others:
        what = "there is no other axis whose angle and torque are recorded"
        raise NumericsError(what, where=record.name, hint="see init_flex.experiments in the manual")
    found = {OWN: replace(record, tau_m=torque)}
    for name in others:
        angle = record.companions[name].values
        speed = central_difference(angle, h)
        drive = record.companions[drive_of(name)].values
        found[name] = replace(record, tau_m=drive - _dry_friction(drive, speed, record), phi_m=angle, dphi_m=speed)
    return found


def _dry_friction(torque: Array, speed: Array, record: Record) -> Array:
    """Coulomb friction in a torque (n,) of another axis, by regression on the motion of all."""
    h = record.sampling_time
    speeds = [record.dphi_m, *(central_difference(record.companions[name].values, h) for name in _others(record))]
    inertial = [central_difference(one, h) for one in speeds]
    direction = np.sign(speed)
    columns = np.column_stack([direction, np.ones(len(torque)), speed, *inertial])
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    weights = np.linalg.lstsq(scaled, torque, rcond=None)[0]
    return np.asarray(weights[0] * scaled[:, 0])


def _count(groups: int, experiments: int) -> str:
    return f"{experiments} experiments" if groups == 1 else f"the log mean of {groups} times {experiments} experiments"
