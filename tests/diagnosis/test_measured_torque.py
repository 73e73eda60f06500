"""Whether a model bears the recorded torque out along the measured motion, whatever its simulation comes near to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from support.mistaken_logs import MISTAKES, H, right_log
from support.small_bench import AXIS, QUICK, TRUTH, fitted, records

from robotid.catalogue import assemble
from robotid.diagnosis import Diagnosis, diagnose
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.measured_torque import CONTRADICTED, MeasuredTorque, contradicts
from robotid.estimate.fitted_model import FittedModel, fitted_model
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.regressor import friction_power
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.record import Record

HEAVY = {"motor.inertia.J": 60.0, "motor.viscous.Fv": 40.0, "motor.coulomb.Fc": 0.0}
"""Factors on the truth of a model that hardly moves."""


def model(factors: Mapping[str, float], made: list[Record]) -> FittedModel:
    found = fitted_model(fitted(made))
    values = {name: factors.get(name, 1.0) * value for name, value in TRUTH.items()}
    return replace(found, parameters=found.parameters.with_values(values))


def opposite(made: list[Record]) -> list[Record]:
    return [replace(record, tau_m=-record.tau_m) for record in made]


def contradicted(fitted: FittedModel, made: list[Record]) -> bool:
    """By the first two records, of the fit."""
    return contradicts(fitted, MeasuredTorque.of(fitted.joint, fitted.parameters, made[:2]), QUICK)


def test_a_torque_of_the_other_sign_is_one_that_no_physical_effect_explains() -> None:
    made = records({})
    assert contradicted(model(HEAVY, made), opposite(made))


def test_a_model_that_is_wrong_of_a_torque_that_it_could_explain_is_searched() -> None:
    made = records({})
    assert not contradicted(model(HEAVY, made), made)


def test_a_model_that_lacks_what_holds_most_of_the_torque_is_searched() -> None:
    made = records({"motor.constant_torque.tau0": 20.0})
    assert not contradicted(model(HEAVY, records({})), made)


def test_a_model_that_is_right_is_searched() -> None:
    made = records({})
    assert not contradicted(model({}, made), made)


def test_what_the_torque_of_records_tells_is_known_of_these_alone() -> None:
    made = records({})
    found = MeasuredTorque.of(assemble(AXIS), fitted_model(fitted(made)).parameters, made)
    assert found is not None
    assert found.is_of(made)
    assert not found.is_of(made[:1])
    assert found.is_of([replace(one, tau_m=one.tau_m.copy()) for one in made])
    assert not found.is_of([replace(one, tau_m=1.01 * one.tau_m) for one in made])


def test_friction_absorbs_power_and_drives_where_it_is_negative() -> None:
    joint, (slow, *_) = assemble(AXIS), records({}, quiet=True)
    dry = joint.parameters().with_values({"motor.viscous.Fv": 0.0, "motor.coulomb.Fc": 0.5})
    expected = 0.5 * float(np.mean(np.abs(slow.dphi_m)))
    assert friction_power(joint, dry, slow, ParallelFilter(40.0)) == pytest.approx(expected, rel=0.03)
    driving = dry.with_values({"motor.coulomb.Fc": -0.5})
    assert friction_power(joint, driving, slow, ParallelFilter(40.0)) == pytest.approx(-expected, rel=0.03)


def mistaken() -> Diagnosis:
    """An axis whose angle was taken for its speed: the torque belongs to the angle."""
    log = right_log("rigid")
    wrong = next(m for m in MISTAKES if m.name == "speed_is_angle").make(log)
    record = Record("log", "estimate", "both", H, wrong["tau_m"], wrong["phi_m"], wrong["dphi_m"])
    joint = assemble(AXIS)
    fit = fit_model("m", joint, joint.parameters().with_values(TRUTH), [record], FitOptions())
    return diagnose(fit, [record], Criteria(max_refits=1, max_causes=1))


def test_what_needs_another_torque_than_was_recorded_is_no_cause() -> None:
    found = mistaken()
    assert found.verdict == "unknown"
    assert found.causes == ()
    assert any(one.why.startswith("contradicts the recorded torque") for one in found.rejected)


def test_a_diagnosis_of_a_torque_of_the_other_sign_ends_before_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    made = records({})
    monkeypatch.setattr("robotid.diagnosis.procedure.explains_nothing", lambda *_: False)
    found = diagnose(model(HEAVY, made), opposite(made), QUICK)
    assert (found.verdict, found.causes, found.remarks) == ("not explained", (), (CONTRADICTED,))


def test_pieces_are_of_the_whole_records_with_their_torque() -> None:
    made = records({})[:2]
    known = MeasuredTorque.of(assemble(AXIS), fitted_model(fitted(made)).parameters, made)
    assert known is not None
    pieces = [piece for record in made for piece in record.pieces(0.5)]
    assert known.is_of(known.whole(pieces))
    without = [replace(piece, tau_m=piece.tau_m - 1.0) for piece in pieces]
    assert all(
        np.allclose(one.tau_m, record.tau_m - 1.0) for one, record in zip(known.whole(without), made, strict=True)
    )
    assert known.whole(pieces[:-1]) == pieces[:-1]
