"""The torque of a log may be recorded late by what its clock explains, and no cause is sought for that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from support.dry_axis import DryAxis
from support.plain_models import plain_data, plain_model
from support.small_bench import QUICK, SAMPLING_TIME, STRIBECK, begun, evidence, fitted, records

from robotid.catalogue import assemble
from robotid.diagnosis import clock, procedure
from robotid.diagnosis.clock import InTime, RecordedLate, in_time
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.procedure import DiagnosisOptions, diagnose
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.rounds import as_result
from robotid.diagnosis.search.state import AcceptedCause, SearchResult
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.extension.task import extension_task
from robotid.interrupt import OutOfTime
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.measured import Selection, measured_records
from robotid.signals.readers.table import Table
from robotid.signals.record import Record
from robotid.signals.torque_steps import moved

H = 0.01  # [s]
SKIPPING = replace(QUICK, skip=(*QUICK.skip, "torque.torque_delay"))


def with_torque_moved(made: list[Record], late: float) -> list[Record]:
    """Records whose torque is recorded so many intervals late, as of an irregular log."""
    pairs = [(one, *moved(one.tau_m, None, late)) for one in made]
    return [replace(one, tau_m=torque, torque_steps=steps) for one, torque, steps in pairs]


def irregular(late: float, **settings: float) -> Evidence:
    """A rigid axis with dry friction, its motion recorded up to 0.24 intervals later than its torque acts, and `late`
    intervals besides, the model fitted. settings : of the record."""
    n, rng, axis = 1000, np.random.default_rng(2), DryAxis()
    cycles = np.arange(n) * H
    stamps = cycles + H * (late + rng.uniform(0.0, 0.24, n))
    speed, angle = axis.motion(cycles, waves(cycles), stamps)
    log = {"t": stamps - stamps[0], "tau_m": waves(cycles), "phi_m": angle}
    log["dphi_m"] = speed + 0.002 * rng.standard_normal(n)
    ((record, _),) = measured_records(Selection("a", **settings), Table("a.csv", log))
    joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
    start = joint.parameters().with_values(
        {"motor.inertia.J": 0.02, "motor.viscous.Fv": axis.Fv, "motor.coulomb.Fc": axis.Fc}
    )
    model = fitted_model(fit_model("m", joint, start, [record], FitOptions()))
    return Evidence(model, [simulate_record(model, record)], [])


def waves(t: Array) -> Array:
    """A torque [Nm] of three frequencies."""
    found = 1.4 * np.sin(2 * np.pi * 0.9 * t + 0.4) + np.sin(2 * np.pi * 3.1 * t) + 0.6 * np.sin(2 * np.pi * 7.3 * t)
    return np.asarray(found)


@pytest.mark.parametrize("late", [0.0, 0.5])
def test_a_recorder_with_a_clock_of_its_own_is_late(late: float) -> None:
    seen = irregular(late)
    found = in_time(seen, Criteria())
    assert found.clock.late == pytest.approx((late + 0.12) * H, rel=0.15)
    before, after = (np.std(one.fitted[0].segments("speed")[0].residual) for one in (seen, found.evidence))
    assert after < 0.65 * before


def test_a_delay_that_is_given_is_taken_out_within_intervals() -> None:
    before, after = (
        np.std(irregular(0.5, torque_delay=late).fitted[0].segments("speed")[0].residual) for late in (0.0, 0.62 * H)
    )
    assert after < 0.2 * before


def test_what_a_clock_does_not_explain_is_left_alone() -> None:
    assert in_time(irregular(1.2), Criteria()).clock.late == 0.0


def regular(late: float) -> list[Record]:
    """Records of a drive that sets its torque more often than it logs it, which puts it so many intervals late."""
    return [replace(one, torque_steps=None) for one in with_torque_moved(records({}), late)]


@pytest.mark.parametrize("late", [0.25, 0.45])
def test_a_drive_that_controls_faster_than_it_logs_is_late_by_part_of_an_interval(late: float) -> None:
    seen = evidence(regular(late))
    found = in_time(seen, QUICK)
    assert found.clock.late == pytest.approx(late * SAMPLING_TIME, abs=0.1 * SAMPLING_TIME)
    before, after = (np.std(one.fitted[1].segments("speed")[0].residual) for one in (seen, found.evidence))
    assert after < 0.8 * before


def test_a_log_may_hold_the_torque_of_its_last_interval() -> None:
    """A whole interval, which explains more than any effect, for none is early; not beside one that explains more."""
    found = in_time(evidence(regular(1.0)), QUICK)
    assert found.clock.late == pytest.approx(SAMPLING_TIME, abs=0.1 * SAMPLING_TIME)
    assert found.start.misfit < 0.1 * in_time(evidence(regular(1.0)), SKIPPING).start.misfit
    beside = [replace(one, torque_steps=None) for one in with_torque_moved(records(STRIBECK), 0.6)]
    assert in_time(evidence(beside), QUICK).clock.late == 0.0


@pytest.mark.parametrize("late", [2.0, -0.4])
def test_what_no_clock_explains_of_a_regular_log_may_have_a_cause(late: float) -> None:
    assert in_time(evidence(regular(late)), QUICK).clock.late == 0.0


def test_a_torque_in_time_stays_as_it_is() -> None:
    assert in_time(evidence(with_torque_moved(records({}), 1e-9)), QUICK).clock.late == 0.0


def test_an_effect_that_the_model_lacks_is_no_delay() -> None:
    found = in_time(evidence(records(STRIBECK)), QUICK)
    assert abs(found.clock.late) < 0.02 * SAMPLING_TIME


def test_no_delay_is_taken_out_that_is_not_to_be_looked_for() -> None:
    for made in (with_torque_moved(records({}), 0.3), regular(0.3)):
        assert in_time(evidence(made), SKIPPING).clock.late == 0.0


def test_of_records_with_unlike_clocks_each_moves_by_what_its_own_explains() -> None:
    jittered, held = with_torque_moved(records({}), 0.3)[0], records({})[0]
    late = RecordedLate(0.8 * SAMPLING_TIME)
    assert late.corrected(held) is held
    assert not np.array_equal(late.corrected(jittered).tau_m, jittered.tau_m)


def test_a_diagnosis_says_by_how_much_the_torque_was_moved_and_finds_nothing_else() -> None:
    made = with_torque_moved(records({}), 0.3)
    said: list[str] = []
    found = diagnose(fitted(made), made, QUICK, log=said.append)
    assert found.verdict == "clean"
    remark = next(one for one in found.remarks if " ms late, within what clocks explain: moved by" in one)
    assert remark in said
    assert float(remark.split("recorded ")[1].split()[0]) == pytest.approx(0.6, abs=0.05)
    assert found.late == pytest.approx(0.3 * made[0].sampling_time, rel=0.1)
    task = extension_task(found, fitted(made), made)
    for one, plain in zip(task.records, records({}), strict=True):
        before = np.std(made[task.records.index(one)].tau_m - plain.tau_m)
        assert np.std(one.tau_m - plain.tau_m) < 0.2 * before


def test_beside_slow_errors_of_the_torque_the_motion_of_a_rigid_axis_tells_the_delay() -> None:
    rng, made = np.random.default_rng(3), list[Record]()
    for one in regular(0.3):
        error = 0.1 * lfilter([np.sqrt(1.0 - 0.999**2)], [1.0, -0.999], rng.standard_normal(len(one)))
        made.append(replace(one, tau_m=one.tau_m + error))
    found = in_time(evidence(made), QUICK)
    assert found.clock.late == pytest.approx(0.3 * SAMPLING_TIME, abs=0.15 * SAMPLING_TIME)


@pytest.mark.parametrize("in_time", [True, False])
def test_a_delay_that_causes_undo_was_none(monkeypatch: pytest.MonkeyPatch, in_time: bool) -> None:
    """Unless no time is left to search without it: then what was found beside it stays."""
    made = records({})
    seen, late = evidence(made), RecordedLate(0.3 * SAMPLING_TIME)
    asked = list[float]()

    def searching(given: Evidence, *_: object) -> SearchResult:
        asked.append(float(np.abs(given.fitted[0].record.tau_m - made[0].tau_m).max()))
        names = ("motor.stribeck", "torque.torque_delay") if asked[-1] else ("motor.stribeck",)
        causes = tuple(AcceptedCause(one, 0.5, 1.0, 0.0, (one,), *2 * (plain_model(1.0),)) for one in names)
        late = len(asked) > 1 and not in_time
        return SearchResult(plain_data(), plain_model(1.0), plain_model(1.0), () if late else causes, (), (), late=late)

    moved = InTime(late, seen.on(late.corrected), begun(made, QUICK))
    monkeypatch.setattr(procedure, "in_time", lambda *_: moved)
    monkeypatch.setattr(procedure, "search", searching)
    monkeypatch.setattr(procedure, "without_contradicted", lambda found, _: found)
    sought = procedure._sought(seen, None, QUICK, None, lambda _: None)
    clock, found = sought.clock, sought.found
    assert asked[0] > 0.0
    assert asked[1:] == [0.0]
    named = [one.effect for one in found.causes]
    if in_time:
        assert (clock.late, named, found.unexamined) == (0.0, ["motor.stribeck"], ())
    else:
        assert (clock, named) == (late, ["motor.stribeck", "torque.torque_delay"])
        assert found.unexamined == (procedure.NOT_LATE,)


def through_a_filter(made: list[Record], intervals: float) -> list[Record]:
    """Records whose torque a drive has smoothed, by a time constant of so many intervals."""
    smoothed = [lfilter([1.0], [1.0 + intervals, -intervals], one.tau_m) for one in made]
    return [replace(one, tau_m=torque, torque_steps=None) for one, torque in zip(made, smoothed, strict=True)]


@pytest.mark.parametrize("intervals", [0.8, 1.2])
def test_a_torque_that_was_recorded_through_a_filter_is_not_late(intervals: float) -> None:
    made = through_a_filter(records({}), intervals)
    assert in_time(evidence(made), QUICK).clock.late == 0.0
    found = diagnose(fitted(made), made, QUICK)
    (cause,) = found.causes
    assert cause.effect == "torque.torque_filter"
    assert cause.parameters[0].value == pytest.approx(intervals * SAMPLING_TIME, rel=0.05)


def begun_on(seen: Evidence) -> InTime:
    """Where the search for a lateness begins."""
    return InTime(RecordedLate(), seen, first_state(seen, QUICK).scored(QUICK))


def test_a_lateness_whose_promise_means_nothing_is_judged_by_fits() -> None:
    """As of a model that the late torque leads so far astray that an effect promises more than it keeps."""
    seen = evidence(regular(1.0))
    by_fits = clock._late_by_fits(begun_on(seen), QUICK)
    assert by_fits is not None
    assert by_fits.clock.late == pytest.approx(SAMPLING_TIME, abs=0.1 * SAMPLING_TIME)
    lacking = evidence(records(STRIBECK))
    assert clock._late_by_fits(begun_on(lacking), QUICK) is None


@pytest.mark.parametrize("late", [0.4, 1.0])
def test_a_filter_no_slower_than_clocks_explain_is_a_torque_that_is_recorded_late(
    monkeypatch: pytest.MonkeyPatch, late: float
) -> None:
    """As where something larger is missing, beside which it does not show before the search has found that."""
    monkeypatch.setattr(clock, "_lateness", lambda *_: (0.0, np.inf))
    made = [replace(one, torque_steps=None) for one in with_torque_moved(records(STRIBECK), late)]
    found = diagnose(fitted(made), made, QUICK)
    assert [cause.effect for cause in found.causes] == ["motor.stribeck"]
    assert found.late == pytest.approx(late * SAMPLING_TIME, abs=0.1 * SAMPLING_TIME)
    extended = extension_task(found, fitted(made), made).records
    assert not any(np.array_equal(one.tau_m, before.tau_m) for one, before in zip(extended, made, strict=True))


@pytest.mark.parametrize("ends", ["asked", "searched"])
def test_a_filter_that_no_time_is_left_to_take_for_a_lateness_stays_as_it_was_found(
    monkeypatch: pytest.MonkeyPatch, ends: str
) -> None:
    made, searches, searching = regular(0.4), list[Evidence](), procedure.search

    def too_late(*_: object) -> None:
        raise OutOfTime

    def once(given: Evidence, criteria: Criteria, *more: object) -> SearchResult:
        searches.append(given)
        found = searching(given, criteria, lambda _: None)
        return found if len(searches) == 1 else replace(found, late=True)

    monkeypatch.setattr(clock, "_lateness", lambda *_: (0.0, np.inf))
    if ends == "asked":
        monkeypatch.setattr(clock, "deviation", too_late)
    else:
        monkeypatch.setattr(procedure, "search", once)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=600.0))
    assert (found.late, [cause.effect for cause in found.causes]) == (0.0, ["torque.torque_filter"])
    assert f"the budget of 600 s is spent; not examined: {procedure.LATE_INSTEAD}" in found.remarks
    assert len(searches) == (0 if ends == "asked" else 2)


def test_beside_a_cause_a_filter_that_explains_more_than_a_lateness_is_named() -> None:
    made = through_a_filter(records(STRIBECK), 1.2)
    found = diagnose(fitted(made), made, QUICK)
    assert found.late == 0.0
    assert {cause.effect for cause in found.causes} == {"motor.stribeck", "torque.torque_filter"}


def test_a_filter_is_asked_for_unless_it_is_not_to_be_looked_for() -> None:
    made = through_a_filter(records({}), 1.2)
    seen, late = evidence(made), RecordedLate(1.2 * SAMPLING_TIME, 1.5)
    found = as_result(begun(made, QUICK).scored(QUICK))
    assert clock.is_filtered(seen, late, found, QUICK)
    skipping = replace(QUICK, skip=(*QUICK.skip, "torque.torque_filter"))
    assert not clock.is_filtered(seen, late, found, skipping)
    assert not clock.is_filtered(seen, RecordedLate(0.4 * SAMPLING_TIME), found, QUICK)


@pytest.mark.parametrize("sampling_time", [0.0009, 0.006, 0.012])
def test_a_lateness_of_just_what_clocks_explain_is_taken_out(sampling_time: float) -> None:
    """In seconds it is more intervals by rounding."""
    record = replace(records({})[0], sampling_time=sampling_time)
    assert RecordedLate(1.5 * sampling_time, 1.5).corrected(record) is not record


def test_where_no_time_is_left_the_torque_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_late(*_: object) -> None:
        raise OutOfTime

    seen = evidence(regular(0.4))
    found = as_result(begun_on(seen).start)
    assert not clock.is_filtered(seen, RecordedLate(1.2 * SAMPLING_TIME, 1.5), replace(found, late=True), QUICK)
    monkeypatch.setattr(clock, "_refitted_on", too_late)
    assert not clock.is_filtered(seen, RecordedLate(1.2 * SAMPLING_TIME, 1.5), found, QUICK)
    monkeypatch.setattr(clock, "_lateness", too_late)
    left = in_time(seen, QUICK)
    assert (left.clock.late, len(left.start.rounds)) == (0.0, 1)
