"""The body of a robot from the records of one of its axes, whose signals hold the angles and torques of the others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.body.equations import Motion, Structure
from robotid.body.identification import Identified, Knowledge, identify
from robotid.body.pinocchio_model import require_agreement
from robotid.body.regressor import own_inertia, torques
from robotid.body.results import INERTIA, TORQUE
from robotid.errors import ConfigError
from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.signals.companion import ENERGY_SHARE, MARGIN, Companion
from robotid.signals.differentiate import bandwidth, central_difference, decimate, differentiate, kept
from robotid.signals.quality import Recordings
from robotid.signals.record import Record

ROUNDING = 1e-12  # of an inertia
SAMPLES_A_PERIOD = 12.0  # of the cut-off, at least: with fewer, central differences are too small by a tenth


@dataclass(frozen=True, slots=True)
class AxisSignals:
    """Where the records have an axis. angle, torque : companions, of the angle behind the gear and of the motor's
    torque; empty for the joint of the records itself. gear_ratio : phi_a / phi_m."""

    gear_ratio: float
    angle: str = ""
    torque: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class BodySetup:
    """What is to be identified. axes : by name, from the base on; axis : which one the records are of; cutoff [Hz] :
    None where the motion of a record decides."""

    structure: Structure
    axes: Mapping[str, AxisSignals]
    axis: str
    known: Knowledge = field(default_factory=Knowledge)
    cutoff: float | None = None


def identify_body(recordings: Recordings, setup: BodySetup) -> Identified:
    """The body from the records of any of its axes.

    Raises ConfigError where a signal is missing, NumericsError where the records do not determine a body.
    """
    require_agreement(setup.structure.chain)
    cutoffs = {record.name: setup.cutoff or choose_cutoff(record, setup) for record in recordings.records}
    motions = [_regressed(record, setup, cutoffs[record.name]) for record in recordings.records]
    return identify(setup.structure, motions, setup.known, cutoffs)


def with_body(recordings: Recordings, setup: BodySetup, found: Identified) -> Recordings:
    """Records with the companions that the body of the robot adds, and the body itself. Raises ConfigError where a
    signal is missing."""
    cutoffs = found.result.cutoff
    axis = list(setup.axes).index(setup.axis)
    inertias, rests = {}, {}
    for record in recordings.records:
        inertias[record.name], rests[record.name] = _of_axis(record, setup, cutoffs[record.name], found, axis)
    fitted = [inertias[record.name] for record in recordings.records if record.role == "estimate"]
    mean = float(np.mean(np.concatenate(fitted)))
    changes = {name: np.where(np.abs(own - mean) > ROUNDING * mean, own - mean, 0.0) for name, own in inertias.items()}
    records = tuple(
        replace(
            record,
            companions=record.companions
            | {
                INERTIA: Companion.of(CompanionKind.INERTIA, changes[record.name], record.sampling_time),
                TORQUE: Companion.of(CompanionKind.TORQUE, -rests[record.name], record.sampling_time),
            },
        )
        for record in recordings.records
    )
    return replace(recordings, records=records, body=found.result)


def choose_cutoff(record: Record, setup: BodySetup) -> float:
    """Cut-off [Hz] that leaves the band of every axis' speed alone, and of the noise beyond lets as little pass."""
    h = record.sampling_time
    bands = [bandwidth(central_difference(angle, h), h, ENERGY_SHARE) for angle in _signals(record, setup)[0]]
    return min(MARGIN * max(1.0 / record.duration, *bands), 1.0 / (SAMPLES_A_PERIOD * h))


def _signals(record: Record, setup: BodySetup) -> tuple[Array, Array]:
    """Angles [rad] and torques [Nm] of all axes behind their gears, (axes, n) each."""
    angles, torque = [], []
    for name, axis in setup.axes.items():
        if name == setup.axis:
            angles.append(record.phi_m * axis.gear_ratio)
            torque.append(record.tau_m / axis.gear_ratio)
            continue
        for wanted in (axis.angle, axis.torque):
            if wanted not in record.companions:
                hint = "add it to the record's signals"
                raise ConfigError(f"record {record.name} has no signal {wanted}", where="robot.body.axes", hint=hint)
        angles.append(record.companions[axis.angle].values)
        torque.append(record.companions[axis.torque].values / axis.gear_ratio)
    return np.array(angles), np.array(torque)


def _kinematics(angles: Array, sampling_time: float, cutoff: float) -> tuple[Array, Array, Array]:
    """Filtered angles of all axes, their speeds and accelerations, (axes, n) each."""
    each = [differentiate(angle, sampling_time, cutoff) for angle in angles]
    return (
        np.array([one.position for one in each]),
        np.array([one.speed for one in each]),
        np.array([one.acceleration for one in each]),
    )


def _regressed(record: Record, setup: BodySetup, cutoff: float) -> Motion:
    """A record as the regression takes it."""
    h = record.sampling_time
    angles, torque = _signals(record, setup)
    at = kept(angles.shape[1], h, cutoff)
    q, dq, ddq = _kinematics(angles, h, cutoff)
    direction, filtered = decimate(np.sign(dq), h, cutoff), decimate(torque, h, cutoff)
    fitted = record.role == "estimate"
    return Motion(record.name, q[:, at], dq[:, at], ddq[:, at], direction, filtered, fitted)


def _of_axis(record: Record, setup: BodySetup, cutoff: float, found: Identified, axis: int) -> tuple[Array, Array]:
    """Inertia of an axis [kg m2], and the torque that its body takes beside what accelerates that [Nm], (n,) each."""
    angles, _ = _signals(record, setup)
    q, dq, ddq = _kinematics(angles, record.sampling_time, cutoff)
    own = own_inertia(found.chain, found.links, q, axis)
    return own, torques(found.chain, found.links, q, dq, ddq)[axis] - own * ddq[axis]
