"""A curve as a torque in time: what acts on a record, given along the motion that was measured there.

A curve that no term can be, as one along the motor's angle that acts on the gear, still has a value at every sample. As
a recorded torque beside that of the motor it moves the joint, and other effects can be sought beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.nonparametric.basis import Basis, Variable, at_measured_speed, torques
from robotid.diagnosis.nonparametric.curve_term import starts_along, sweep_options
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, carried
from robotid.model.array import Array
from robotid.model.companion import CompanionKind, with_companion
from robotid.model.port import Port
from robotid.model.structure import Structure
from robotid.signals.companion import Companion
from robotid.signals.record import Record
from robotid.terms.known_torque import KnownTorque

NAMES = {Port.MOTOR: "a curve, at the motor", Port.ARM: "a curve, at the arm"}
"""Of the companions that a curve becomes."""
DRIVING = ("tau_m", "ddphi_m")
"""Variables that tell what drives a motion rather than where it is."""
READERS = tuple(with_companion(KnownTorque.name, name) for name in NAMES.values())
"""The effects that read them, without their place."""


def can_act_in_time(variable: Variable) -> bool:
    """Whether a curve along a variable is no more than a torque where the motion passes. One along the recorded torque,
    or along the measured acceleration, tells a simulation how the machine moved: a controller that follows a course
    asks for the torque that this needs, and whatever a model lacks is in it."""
    return variable.along not in DRIVING


def with_course(record: Record, course: Mapping[Port, Array]) -> Record:
    """The record with a torque at every sample [Nm], (n,) at each port, among its companions."""
    found = {
        NAMES[port]: Companion.of(CompanionKind.TORQUE, values, record.sampling_time) for port, values in course.items()
    }
    return replace(record, companions={**record.companions, **found})


def beside_course(structure: Structure, ports: Iterable[Port]) -> Structure:
    """The structure with such torques at these ports, as far as it has none."""
    for port in ports:
        effect = f"{port}.{with_companion(KnownTorque.name, NAMES[port])}"
        structure = structure if effect in structure.terms else structure.extended(effect)
    return structure


def course_of(one: SegmentFit, basis: Basis, values: Array) -> dict[Port, Array]:
    """A curve with these values (k,) on a segment, along the motion that was measured there, the rest of it as
    simulated."""
    return torques(basis, at_measured_speed(one.trajectory, one.record), values)


def joined_courses(segments: Iterable[SegmentFit]) -> dict[str, dict[Port, Array]]:
    """The torques of a curve on whole records, by name, of the pieces in which these were simulated, in order."""
    found: dict[str, dict[Port, list[Array]]] = {}
    for one in segments:
        own = found.setdefault(one.record.name, {})
        for port, name in NAMES.items():
            if name in one.record.companions:
                own.setdefault(port, []).append(one.record.companions[name].values)
    return {name: {port: np.concatenate(parts) for port, parts in own.items()} for name, own in found.items()}


def refit_beside_course(
    near: RefittedModel, data: EvaluationData, basis: Basis, values: Array, moved: Array
) -> tuple[RefittedModel, EvaluationData]:
    """A model refitted beside a curve with these values (k,), its parameters moved (p,) along with the curve at first,
    and the data with the curve among the companions.

    near : the model, with such torques or without. Raises NumericsError where it cannot be simulated.
    """

    def segment(kept: Segment, one: SegmentFit) -> Segment:
        return Segment(with_course(kept.record, course_of(one, basis, values)), kept.whitening)

    data = replace(
        data,
        fitted=tuple(map(segment, data.fitted, near.fitted)),
        validation=tuple(map(segment, data.validation, near.validation)),
    )
    ports = course_of(near.fitted[0], basis, values)
    structure = beside_course(near.structure, ports)
    gains = {f"{effect}.g": 1.0 for effect in structure.effects if is_course(effect)}
    starts = [carried(one, structure, {}).held_at(gains) for one in starts_along(near, moved)]
    return refit(structure, starts, data, near.trajectories, sweep_options()), data


def is_course(effect: str) -> bool:
    """Whether an effect is the torque of a curve in time."""
    return effect.partition(".")[2] in READERS
