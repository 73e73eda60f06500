"""The model under the controller that made the record."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.judged_records import CONTROLLER, clean_records, model
from support.paper_joint import STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.model.companion import CompanionKind
from robotid.signals.companion import Companion
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.loop import ControlledJoint
from robotid.validation.closed_loop import loop_errors

RECORD = clean_records()[0]


def test_the_truth_repeats_the_record():
    errors = loop_errors(STRUCTURE, model({}).theta, CONTROLLER, RECORD)
    assert errors is not None
    assert max(errors.position_percent, errors.speed_percent, errors.torque_percent) < 1e-4
    assert max(errors.position_rmse, errors.speed_rmse, errors.torque_rmse) < 1e-5


def test_the_controller_hides_in_speed_what_it_pays_for_in_torque():
    errors = loop_errors(
        STRUCTURE, model({"motor.coulomb.Fc": 1.5 * TRUTH["motor.coulomb.Fc"]}).theta, CONTROLLER, RECORD
    )
    assert errors is not None
    assert errors.torque_percent > 3 * errors.speed_percent > 0.1


def test_without_a_reference_of_its_kind_there_is_no_loop():
    theta = model({}).theta
    assert loop_errors(STRUCTURE, theta, CONTROLLER, replace(RECORD, ref=None, ref_kind=None)) is None
    assert loop_errors(STRUCTURE, theta, Controller("position", 0.5, kpos=10.0), RECORD) is None


def test_rmse_and_percent_agree():
    errors = loop_errors(STRUCTURE, model({"motor.coulomb.Fc": 0.5}).theta, CONTROLLER, RECORD)
    assert errors is not None
    rms = float(np.sqrt(np.mean(RECORD.tau_m**2)))
    assert errors.torque_rmse == pytest.approx(errors.torque_percent / 100 * rms)


def test_a_closed_loop_turns_by_its_own_angle():
    """Beside a record a cogging may act at the recorded angle; here the controller keeps the simulated one near it."""
    structure = STRUCTURE.extended("motor.cogging")
    values = TRUTH | {"motor.cogging.A": 0.1, "motor.cogging.n": 6.0}
    theta = assemble(structure, angle=True).parameters().with_values(values).values
    own, recorded = (
        loop_errors(replace(structure, recorded_angle=given), theta, CONTROLLER, RECORD) for given in (False, True)
    )
    assert own == recorded
    assert own.torque_percent > 1.0


def test_a_disturbance_acts_beside_the_command():
    """Pulses of torque that the controller did not command: with them the truth repeats the record, without it not."""
    joint = assemble(STRUCTURE, angle=True)
    theta = joint.parameters().with_values(TRUTH).values
    pulses = np.where(RECORD.t % 0.5 < 0.1, 1.5, 0.0)
    reference = Reference("pulses", RECORD.sampling_time, RECORD.ref, RECORD.ref_kind)
    x, torque = ControlledJoint(joint, theta, CONTROLLER).follow(reference, disturbance=pulses)
    motion = {"phi_m": x[joint.motor_angle], "dphi_m": x[joint.motor_speed]}
    added = Companion.of(CompanionKind.DISTURBANCE, pulses, RECORD.sampling_time)
    disturbed = replace(RECORD, tau_m=torque, companions={"pulses": added}, **motion)
    errors = [loop_errors(STRUCTURE, theta, CONTROLLER, one) for one in (disturbed, replace(disturbed, companions={}))]
    assert errors[0].torque_percent < 1e-4
    assert errors[1].torque_percent > 20
