"""First states are tied to what was measured, by its accuracy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.estimate.first_states import angle_accuracy, first_state_limits, speed_accuracy
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.model.structure import Structure
from robotid.signals.record import Record

AXIS = Structure(("motor.inertia", "motor.viscous"))
H, NOISE = 1e-3, 0.05


def steady(noise: float = NOISE) -> Record:
    """An axis that runs on at 20 rad/s without a torque, its speed noisy, for two seconds."""
    speed = 20.0 * np.exp(-np.arange(2000) * H)
    noisy = speed + noise * np.random.default_rng(1).standard_normal(2000)
    return Record("r", "estimate", "both", H, 0 * speed, 20.0 - speed, noisy)


def test_the_limits_are_deviations_of_the_measurement() -> None:
    record = steady()
    least, most = first_state_limits(assemble(AXIS), record)
    steps = 2.0 * np.abs(np.diff(record.dphi_m[:5])).max()
    allowed = 5.0 * NOISE + steps + 0.05 * float(np.sqrt(np.mean(record.dphi_m**2)))
    assert most[0] - record.dphi_m[0] == pytest.approx(allowed, rel=0.05)
    assert record.dphi_m[0] - least[0] == pytest.approx(most[0] - record.dphi_m[0])


def test_what_is_not_measured_has_no_limits() -> None:
    joint = assemble(Structure((*AXIS.terms, "gear.spring", "gear.damper", "arm.inertia"), gear_ratio=0.01), angle=True)
    least, most = first_state_limits(joint, steady())
    known = [joint.motor_angle, joint.motor_speed]
    assert np.isfinite(most[known]).all()
    assert np.isinf(np.delete(most, known)).all()
    assert np.isinf(np.delete(least, known)).all()


def test_the_accuracy_is_the_quantum_where_that_is_coarse() -> None:
    record, quantum = steady(0.0), 2 * np.pi / 500
    coarse = replace(record, phi_m=quantum * np.round(record.phi_m / quantum))
    assert speed_accuracy(coarse) == pytest.approx(quantum / np.sqrt(6) / H, rel=1e-3)
    assert quantum / np.sqrt(12) < angle_accuracy(coarse) < 3 * quantum / np.sqrt(12)


def test_a_first_speed_stays_at_the_measured_one() -> None:
    record = steady()
    wrong = replace(record, tau_m=record.tau_m - 0.1)  # as if a torque braked, which needs a faster start
    joint = assemble(AXIS)
    start = joint.parameters().with_values({"motor.inertia.J": 0.01, "motor.viscous.Fv": 0.01})
    fit = fit_model("m", joint, replace(start, free=np.zeros(2, dtype=bool)), [wrong], FitOptions())
    least, most = first_state_limits(joint, wrong)
    assert fit.initial_states["r"][0] == most[0]
    well = fit_model("m", joint, replace(start, free=np.zeros(2, dtype=bool)), [record], FitOptions())
    assert least[0] < well.initial_states["r"][0] < most[0]
    assert well.initial_states["r"][0] == pytest.approx(20.0, abs=0.01)
