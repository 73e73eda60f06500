"""A diagnosis in the domain's terms: a fit and records in, a verdict out, no file between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import pytest
from support.small_bench import STRIBECK, fitted, records

from robotid.diagnosis import Criteria, Diagnosis, DiagnosisOptions, diagnose, procedure
from robotid.errors import ConfigError, NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated
from robotid.estimate.grey_box import FitOptions
from robotid.extension import effects_to_add, extend, extension_task, with_gains
from robotid.signals.record import Record

CRITERIA = Criteria(max_causes=1, max_refits=1, skip=("power_friction", "record_change"))


@cache
def made() -> tuple[Record, ...]:
    return tuple(records(STRIBECK))


@cache
def found(*, validated: bool = True) -> Diagnosis:
    return diagnose(fitted(list(made())), made() if validated else made()[:2], CRITERIA)


def test_causes_are_validated_on_the_records_that_the_fit_does_not_name() -> None:
    (cause,) = found().causes
    assert (found().verdict, cause.effect) == ("named", "motor.stribeck")
    assert cause.heldout_gain > 1.0
    assert set(found().records) == {"slow", "wide", "check"}


def test_without_further_records_a_cause_has_no_gain() -> None:
    d = found(validated=False)
    assert [cause.effect for cause in d.causes] == ["motor.stribeck"]
    assert d.causes[0].heldout_gain != d.causes[0].heldout_gain  # nan
    assert set(d.records) == {"slow", "wide"}


def test_no_experiment_is_proposed_where_none_can_be_driven() -> None:
    assert DiagnosisOptions().experiments is None
    assert all(cause.separation is None for cause in found().causes)


def test_what_goes_on_is_logged_and_long_records_are_sampled() -> None:
    said = list[str]()
    d = diagnose(fitted(list(made())), made(), CRITERIA, DiagnosisOptions(max_samples=1500), said.append)
    assert any("scoring the catalogue" in text for text in said)
    assert [remark for remark in d.remarks if "1500 of 2000" in remark] == [t for t in said if "1500 of 2000" in t]
    assert len(d.remarks) >= 3


def test_an_extension_shows_the_gains_that_the_diagnosis_reports() -> None:
    fit = fitted(list(made()))
    task = extension_task(found(), fit, made(), FitOptions())
    (cause,) = with_gains(found(), task).causes
    extension = extend(task, effects_to_add(found(), fit))
    assert extension.added == ("motor.stribeck",)
    gained = extension.after["check"].fit_percent - extension.before["check"].fit_percent
    assert cause.heldout_gain == pytest.approx(gained, abs=1e-6)
    assert {p.name: p.value for p in cause.parameters}.keys() == STRIBECK.keys()


def test_a_cause_that_turns_with_the_motor_says_at_which_angle_it_acts() -> None:
    turning = tuple(records({"motor.cogging.A": 0.15, "motor.cogging.B": 0.1, "motor.cogging.n": 9.0}))
    for these, diagnosis in ((made(), found()), (turning, diagnose(fitted(list(turning)), turning, CRITERIA))):
        fit = fitted(list(these))
        judged = with_gains(diagnosis, extension_task(diagnosis, fit, these, FitOptions()))
        turns = judged.causes[0].effect == "motor.cogging"
        assert len(judged.causes) == 1
        assert turns is (these is turning)
        assert any("act at the recorded angle" in remark for remark in judged.remarks) is turns
        assert extension_task(judged, fit, these).structure_with(["motor.cogging"]).recorded_angle


def test_a_held_out_record_that_repeats_a_fitted_motion_proves_little() -> None:
    again = replace(made()[0], name="again", role="validate")
    remarks = diagnose(fitted(list(made())), [*made()[:2], again], CRITERIA).remarks
    assert "again repeats the motion of slow, which is fitted: a gain on it proves little" in remarks
    assert not any("repeats the motion" in remark for remark in found().remarks)


def lost(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """One record cannot be simulated: in a pose that no other record has a mass may be negative."""
    simulate_record = procedure.simulate_record

    def of_one(model: FittedModel, record: Record, horizon: float | None) -> Simulated:
        if record.name == name:
            raise NumericsError("a mass is not positive in every pose")
        return simulate_record(model, record, horizon)

    def of_all(model: FittedModel, records: Sequence[Record], horizon: float | None) -> list[Simulated]:
        return [of_one(model, record, horizon) for record in records]

    monkeypatch.setattr(procedure, "simulate_record", of_one)
    monkeypatch.setattr(procedure, "simulate_records", of_all)


def test_a_held_out_record_that_cannot_be_simulated_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    lost(monkeypatch, "check")
    d = diagnose(fitted(list(made())), made(), CRITERIA)
    assert f"{d.model} cannot be simulated on check, held out of its fit: no cause is tested there" in d.remarks
    assert ([cause.effect for cause in d.causes], set(d.records)) == (["motor.stribeck"], {"slow", "wide"})


def test_a_record_of_the_fit_that_cannot_be_simulated_ends_a_diagnosis(monkeypatch: pytest.MonkeyPatch) -> None:
    lost(monkeypatch, "slow")
    with pytest.raises(NumericsError, match="a mass is not positive"):
        diagnose(fitted(list(made())), made(), CRITERIA)


def test_without_a_record_of_the_fit_nothing_can_be_diagnosed() -> None:
    hint = "none of these records is one of the fit; give those as well: slow and wide"
    for given in (made()[2:], ()):
        with pytest.raises(ConfigError, match=hint):
            diagnose(fitted(list(made())), given, CRITERIA)
