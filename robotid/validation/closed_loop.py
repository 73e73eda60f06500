"""The model in the loop that made the record: how far position, speed and torque stray from the measured ones."""

from __future__ import annotations

from dataclasses import replace

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.metrics import error_percent, rmse
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.loop import ControlledJoint
from robotid.simulation.first_guess import initial_state
from robotid.validation.results import LoopErrors


def loop_errors(structure: Structure, theta: Array, controller: Controller, record: Record) -> LoopErrors | None:
    """Follow the record's reference with the model under the controller from the measured first state, and compare.

    The record's disturbance acts beside the controller's command, as it did on the machine.

    None where the record has no reference of the controller's kind. Raises NumericsError where the loop diverges.
    """
    if record.ref is None or record.ref_kind != controller.kind:
        return None
    joint = assemble(replace(structure, recorded_angle=False), angle=True).along(record)
    reference = Reference(record.name, record.sampling_time, record.ref, record.ref_kind)
    # Not the first state that suits open loop best: the controller would fight for it what it is not in truth.
    controlled, start = ControlledJoint(joint, theta, controller), initial_state(joint, theta, record)
    x, torque = controlled.follow(reference, x0=start, disturbance=record.disturbance)
    pairs = ((record.phi_m, x[joint.motor_angle]), (record.dphi_m, x[joint.motor_speed]), (record.tau_m, torque))
    return LoopErrors(*(error_percent(*pair) for pair in pairs), *(rmse(*pair) for pair in pairs))
