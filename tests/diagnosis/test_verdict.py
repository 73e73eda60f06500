"""The verdict on what a search has found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from support.small_bench import QUICK, STRIBECK, begun, fitted, records, simulated

from robotid.diagnosis import verdict as verdicts
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.results import Diagnosis
from robotid.diagnosis.search.agreement import Agreement
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.record_changes import RecordChange
from robotid.diagnosis.search.rounds import as_result
from robotid.diagnosis.search.state import AcceptedCause, RejectedCause
from robotid.diagnosis.search.torque_errors import torque_errors
from robotid.diagnosis.verdict import verdict
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.numerals import plain
from robotid.report.tables.diagnose import sentence

CHANGE = "record_change.check.motor.coulomb.Fc"


def with_a_change(hidden: Mapping[str, float]) -> Diagnosis:
    """A search that found nothing but a change of the record that was held out."""
    made = records(hidden)
    found = as_result(begun(made, QUICK).scored(QUICK))
    found = replace(found, changes=(RecordChange(CHANGE, 0.1, "Nm", 0.9, 5.0, 1e-6, (CHANGE,)),))
    return verdict(fitted_model(fitted(made)), simulated(made), found, QUICK)


def test_a_record_differs_from_a_model_that_is_right_elsewhere() -> None:
    found = with_a_change({})
    assert (found.verdict, [c.effect for c in found.causes]) == ("named", [CHANGE])


def test_a_record_does_not_differ_from_a_model_that_is_wrong_everywhere() -> None:
    found = with_a_change(STRIBECK)
    assert (found.verdict, found.causes) == ("unknown", ())
    (rejected,) = (one for one in found.rejected if one.effect == CHANGE)
    assert rejected.why == "only imitates what no effect explains"


def test_only_a_model_that_leaves_noise_on_its_own_records_is_said_to_be_wrong_elsewhere_only() -> None:
    for hidden, apart in (({}, ("check",)), (STRIBECK, ())):
        made = records(hidden)
        found = replace(as_result(begun(made, QUICK).scored(QUICK)), agreement=Agreement(apart=("check",)))
        assert verdict(fitted_model(fitted(made)), simulated(made), found, QUICK).apart == apart


def test_what_acts_like_an_effect_that_makes_no_sense_is_not_clean() -> None:
    made = records({})
    rejected = RejectedCause("motor.thermal_friction", 1.0, 10.0, "makes no sense: T = 1 s")
    for imitates, word in ((False, "clean"), (True, "unknown")):
        found = as_result(begun(made, QUICK).scored(QUICK))
        found = replace(found, rejected=(replace(rejected, imitates=imitates),))
        d = verdict(fitted_model(fitted(made)), simulated(made), found, QUICK)
        assert (d.verdict, any("acts like motor.thermal_friction" in one for one in d.remarks)) == (word, imitates)


def test_a_motion_that_torque_errors_throw_off_is_not_known_to_be_clean(monkeypatch: pytest.MonkeyPatch) -> None:
    made = records({})
    found = as_result(begun(made, QUICK).scored(QUICK))
    for swamped, word in ((False, "clean"), (True, "unknown")):
        monkeypatch.setattr(verdicts, "is_swamped", lambda _, swamped=swamped: swamped)
        d = verdict(fitted_model(fitted(made)), simulated(made), found, QUICK)
        assert (d.verdict, any("would not show" in one for one in d.remarks)) == (word, swamped)
        assert d.is_hidden is swamped
        assert ("would hide whatever is missing" in sentence(d)) is swamped


def test_errors_of_a_tenth_of_the_torque_hide_what_is_missing() -> None:
    made = records({})
    found = as_result(begun(made, QUICK).scored(QUICK))
    torque = np.concatenate([one.record.tau_m for one in found.data.fitted])
    recorded = float(np.sqrt(np.mean(torque**2)))
    for share, word in ((0.08, "clean"), (0.12, "unknown")):
        seen = replace(found, coloured=with_red_noise(found.data, (share * recorded) ** 2))
        size, of_it = torque_errors(seen)
        assert (size, of_it) == pytest.approx((share * recorded, share), rel=0.02)
        d = verdict(fitted_model(fitted(made)), simulated(made), seen, QUICK)
        assert d.verdict == word
        assert (f"errors of the torque, but of {plain(size, 2)} Nm, 12 % of" in "".join(d.remarks)) == (
            word == "unknown"
        )


def test_errors_of_the_torque_that_make_most_of_what_is_left_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    made = records({})
    found = as_result(begun(made, QUICK).scored(QUICK))
    found = replace(found, coloured=replace(with_red_noise(found.data, 1e-4), noise_reached=True))
    for most in (False, True):
        monkeypatch.setattr("robotid.diagnosis.search.torque_errors.prevail", lambda _, most=most: most)
        d = verdict(fitted_model(fitted(made)), simulated(made), found, QUICK)
        assert d.verdict == "clean"
        assert ("passes for errors of the torque of 0.01 Nm" in "".join(d.remarks)) == most
        assert d.torque_errors == pytest.approx(0.01 if most else 0.0, rel=0.01)


def with_red_noise(data: EvaluationData, variance: float) -> EvaluationData:
    """The same data, of whose noise so much is red noise of the torque [Nm2]."""
    levels = (replace(one.whitening.levels, torque=0.0, red=variance) for one in data.fitted)
    filters = (replace(one.whitening, levels=level) for one, level in zip(data.fitted, levels, strict=True))
    return replace(data, fitted=tuple(Segment(one.record, f) for one, f in zip(data.fitted, filters, strict=True)))


def test_levels_that_differ_by_rounding_have_nothing_beyond_each_other() -> None:
    assert verdicts._beyond(0.02 * (1.0 + 1e-12), 0.02) == 0.0
    assert verdicts._beyond(0.05, 0.03) == pytest.approx(0.04)


def test_what_remains_is_weighed_record_by_record_as_the_misfit_is() -> None:
    """Be a record in one piece or in several, of a cause that removes nothing."""
    made = records(STRIBECK)
    model = fitted_model(fitted(made))
    runs = [simulate_record(model, made[0], 0.5), *(simulate_record(model, one) for one in made[1:])]
    found = as_result(first_state(Evidence(model, runs[:2], made[2:]), QUICK).scored(QUICK))
    assert [one.record.name for one in found.data.fitted].count(made[0].name) > 2
    idle = AcceptedCause("motor.viscous", 0.0, 0.0, 1.0, ("motor.viscous",), found.first, found.last)
    d = verdict(model, runs, replace(found, causes=(idle,)), QUICK)
    pieces = [(one.record.name, one.residual) for one in found.last.fitted]
    left = {name: np.concatenate([part for of, part in pieces if of == name]) for name, _ in pieces}
    energy = np.mean([np.mean(residual**2) for residual in left.values()])
    assert d.remaining == pytest.approx(np.sqrt(energy - d.noise_floor**2), rel=1e-9)


def test_a_search_that_was_cut_short_knows_of_no_noise_that_hides_anything() -> None:
    made = records({})
    found = replace(as_result(begun(made, QUICK).scored(QUICK)), late=True)
    d = verdict(fitted_model(fitted(made)), simulated(made), found, QUICK)
    assert (d.verdict, d.is_cut_short, d.is_hidden) == ("unknown", True, False)
    assert "no effect that was examined in time" in sentence(d)
