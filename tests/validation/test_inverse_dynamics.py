"""The torque that a motion needs, with and without a flexible gear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.judged_records import clean_records, model
from support.paper_joint import TRUTH

from robotid.catalogue import assemble
from robotid.model.structure import Structure
from robotid.signals.differentiate import ParallelFilter
from robotid.validation.inverse_dynamics import torque_error


def error(changed: dict[str, float]) -> float:
    m = model(changed)
    found = torque_error(m.joint, m.theta, clean_records()[0], np.zeros(m.joint.nx))
    assert found is not None
    return found


def test_the_truth_needs_the_torque_that_was_applied():
    assert error({}) < 1.5


def test_errors_of_a_parameter_show():
    assert error({"motor.inertia.J": 1.2 * TRUTH["motor.inertia.J"]}) > 8
    assert error({"arm.inertia.J": 1.2 * TRUTH["arm.inertia.J"]}) > 8


def test_a_rigid_axis_would_be_wrong_by_far():
    joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
    rigid = {"motor.inertia.J": 0.0346, "motor.viscous.Fv": 0.013, "motor.coulomb.Fc": 0.644}
    theta = joint.parameters().with_values(rigid).values
    found = torque_error(joint, theta, clean_records()[0], np.zeros(1))
    assert found is not None
    assert found > 30


def test_a_constant_torque_has_no_error():
    still = replace(clean_records()[0], tau_m=np.full(3000, 0.2))
    m = model({})
    assert torque_error(m.joint, m.theta, still, np.zeros(m.joint.nx)) is None
    assert (
        torque_error(m.joint, m.theta, clean_records()[0], np.zeros(m.joint.nx), ParallelFilter(min_speed=1e3)) is None
    )


def test_slow_samples_can_be_left_out():
    m, record = model({"motor.coulomb.Fc": 0.5}), clean_records()[0]
    fast = torque_error(
        m.joint, m.theta, record, np.zeros(3), ParallelFilter(min_speed=float(np.abs(record.dphi_m).max()) / 2)
    )
    assert fast != pytest.approx(error({"motor.coulomb.Fc": 0.5}), rel=1e-3)
