"""All that is said of one model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.judged_records import CONTROLLER, clean_records, model
from support.paper_joint import STRUCTURE, TRUTH

from robotid.artifacts.consistency import mismatches
from robotid.catalogue import assemble
from robotid.estimate.fitted_model import FittedModel
from robotid.model.structure import Structure
from robotid.validation.procedure import ValidationOptions, validate_model

OPTIONS = ValidationOptions(perturbation=20.0, controller=CONTROLLER)


def test_a_perfect_model_without_noise():
    found = validate_model(model({}), clean_records(), (), OPTIONS)
    for name, record in found.records.items():
        assert record.fit_percent == pytest.approx(100, abs=1e-4)
        assert record.rmse_speed < 1e-5
        assert record.rmse_position < 1e-5
        assert record.closed_loop is not None
        assert record.closed_loop.speed_percent < 1e-3
        assert record.used == (name == "small")
        assert record.remarks == ()
    assert [r.role for r in found.records.values()] == ["estimate", "validate"]
    assert found.identifiability == ()
    assert found.covariance.shape == (0, 0)


def test_only_when_asked_are_parameters_perturbed():
    found = validate_model(model({}), clean_records()[:1], (), replace(OPTIONS, perturbation=None))
    assert found.records["small"].perturbation.names == ()


def test_a_record_on_which_the_model_diverges_is_remarked():
    joint = assemble(Structure(("motor.inertia", "motor.viscous")))
    parameters = joint.parameters().with_values({"motor.viscous.Fv": -1.0, "motor.inertia.J": 1e-3})
    unstable = FittedModel("m", joint, parameters, "speed", (), {}, estimate_states=False)
    found = validate_model(unstable, clean_records()[:1], (), OPTIONS)
    assert found.records == {}
    assert found.remarks[0].startswith("small: the simulation diverges")


def test_a_difference_of_a_record_counts_in_all_its_errors():
    large = clean_records()[1]
    differs = "record_change.large.arm.inertia.J"
    joint = assemble(replace(STRUCTURE, changes=(differs,)))
    light = model({"arm.inertia.J": 0.6 * TRUTH["arm.inertia.J"]}, records=("large",))
    values = TRUTH | {"arm.inertia.J": TRUTH["arm.inertia.J"], differs: -0.4 * TRUTH["arm.inertia.J"]}
    changed = replace(light, joint=joint, parameters=joint.parameters().with_values(values))
    expected, found = (validate_model(m, (large,), (), OPTIONS).records["large"] for m in (light, changed))
    assert found.rmse_speed == pytest.approx(expected.rmse_speed, rel=1e-6)
    assert found.torque_error_percent == pytest.approx(expected.torque_error_percent, rel=1e-6)
    assert expected.torque_error_percent > 1.0
    assert found.closed_loop is not None
    assert expected.closed_loop is not None
    assert found.closed_loop.torque_percent == pytest.approx(expected.closed_loop.torque_percent, rel=1e-6)


def test_a_first_state_that_flatters_is_remarked():
    record = clean_records()[0]
    false_start = replace(record, phi_m=record.phi_m + 0.5, dphi_m=np.where(record.t < 0.001, 3.0, record.dphi_m))
    found = validate_model(
        replace(model({}), first_states={}, estimate_states=True), (false_start,), (), ValidationOptions()
    )
    assert any(remark.startswith("first speed 3 off") for remark in found.records["small"].remarks)


def test_traces_of_long_records_are_thinned(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("robotid.signals.trace.MAX_SAMPLES", 1200)
    record = clean_records()[0]
    trace = validate_model(model({}), (record,), (), ValidationOptions()).records["small"].trace
    assert len(trace.t) == len(trace.measured) == len(trace.simulated) <= 1200 < len(record)
    assert trace.t[-1] == pytest.approx(record.t[-1], abs=0.01)


def test_a_model_of_another_joint_than_its_parameters():
    whole = validate_model(model({}), clean_records()[:1], (), replace(OPTIONS, perturbation=None))
    assert list(mismatches(whole)) == []
    others = replace(whole, structure=Structure(("motor.inertia",)))
    assert [text for text in mismatches(others) if text.endswith("not those of its joint")]
    unknown = replace(whole, structure=Structure(("motor.nothing",)))
    assert [text for text in mismatches(unknown) if "no effect" in text]
