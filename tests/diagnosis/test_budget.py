"""A diagnosis within a budget of time: the best answer so far, and what was not examined."""

from __future__ import annotations

import time

import pytest
from support.alike import alike
from support.eventful import PUSH, eventful
from support.small_bench import QUICK, STRIBECK, begun, fitted, records

from robotid.diagnosis import DiagnosisOptions, diagnose
from robotid.diagnosis.results import Event
from robotid.diagnosis.search import events as search_events
from robotid.diagnosis.search import refits, rounds, search
from robotid.diagnosis.search.data import Evidence
from robotid.diagnosis.search.events import SeenEvent
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.grey_box import FitOptions
from robotid.extension import diagnose_with_gains, extension_task, with_gains
from robotid.interrupt import OutOfTime, check, deadline, until


def too_late(*_: object) -> None:
    raise OutOfTime


def test_without_time_nothing_is_named_and_nothing_is_called_clean() -> None:
    made = records(STRIBECK)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=1e-6))
    assert (found.verdict, found.causes) == ("unknown", ())
    (remark,) = found.remarks
    assert remark.startswith("the budget of 1e-06 s is spent; not examined: motor.stribeck")
    assert remark.endswith("further causes, what no effect explains, what differs on the records held out")
    assert found.rejected[0].why == "not examined: the time was up"


@pytest.mark.parametrize("budget", [1e-6, 0.3, 1.0])
def test_a_listener_that_asks_for_the_time_ends_no_diagnosis(budget: float) -> None:
    made = records(STRIBECK)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=budget), log=lambda _: check())
    assert found.verdict in ("unknown", "named")


def test_a_cause_that_was_found_in_time_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rounds, "renew_noise", too_late)
    made = records(STRIBECK)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=60.0))
    assert [cause.effect for cause in found.causes] == ["motor.stribeck"]
    assert found.remarks == (
        "the budget of 60 s is spent; not examined: further causes, what no effect explains,"
        " what differs on the records held out",
    )


def test_a_refit_that_takes_too_long_is_left_and_those_before_it_count(monkeypatch: pytest.MonkeyPatch) -> None:
    made, directly, asked = records(STRIBECK), refits._refit_directly, list[float]()

    def slow(around: refits.Around, one: refits._Attempt) -> object:
        asked.append(one.promised)
        if len(asked) > 1:
            raise OutOfTime
        return directly(around, one)

    monkeypatch.setattr(refits, "_refit_directly", slow)
    monkeypatch.setattr(refits, "hopeful", list)
    monkeypatch.setattr(refits, "is_complete", lambda *_: False)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=60.0))
    assert [cause.effect for cause in found.causes] == ["motor.stribeck"]
    assert "not examined" in found.remarks[0]
    assert any(one.why == "not examined: the time was up" for one in found.rejected)


def test_a_budget_that_is_large_enough_changes_nothing() -> None:
    made = records(STRIBECK)
    fit = fitted(made)
    assert alike(diagnose(fit, made, QUICK, DiagnosisOptions(budget=1e6)), diagnose(fit, made, QUICK))


def test_progress_tells_the_round_the_candidate_and_the_time_left() -> None:
    heard, made = list[str](), records(STRIBECK)
    diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=1e6), heard.append)
    assert any(line.startswith("round 1: refitting with motor.stribeck, 1 of ") for line in heard)
    assert any(line.endswith(" s left") for line in heard)


def test_what_is_announced_once_the_time_is_up_ends_nothing() -> None:
    """A command asks for the time, and for an interrupt, whenever it is told something."""
    made, heard = records(STRIBECK), list[str]()
    fit = fitted(made)

    def told(text: str) -> None:
        check()
        heard.append(text)

    options = DiagnosisOptions(budget=1e-9)
    found = diagnose_with_gains(fitted_model(fit), fit, made, FitOptions(), QUICK, options, told)
    assert any("not examined" in remark for remark in found.remarks)
    assert heard[-1] == "measuring the gains"


def test_gains_that_no_time_is_left_for_are_those_of_the_search() -> None:
    made = records(STRIBECK)
    fit = fitted(made)
    found = diagnose(fit, made, QUICK)
    with deadline(time.monotonic() - 1.0):
        same = with_gains(found, extension_task(found, fit, made))
    assert same.causes == found.causes
    assert same.remarks[-1].startswith("the gains and parameters of the causes are those of the search")


@pytest.mark.parametrize("in_time", [0, 1])
def test_an_event_that_takes_too_long_to_set_aside_stays_and_is_named_as_not_examined(
    in_time: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, ends, setting_aside = eventful(PUSH), list[float | None](), search.without_event

    def too_slow(evidence: Evidence, event: Event) -> Evidence:
        ends.append(until())
        if len(ends) > in_time:
            raise OutOfTime
        return setting_aside(evidence, event)

    monkeypatch.setattr(search, "without_event", too_slow)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=60.0))
    assert (found.verdict, found.events) == ("unknown", ())
    assert None not in ends
    (remark,) = (one for one in found.remarks if "not examined" in one)
    assert remark.startswith("the budget of 60 s is spent; not examined: what happened once in slow at ")


def test_an_event_beside_causes_that_no_time_is_left_to_judge_is_not_examined(monkeypatch: pytest.MonkeyPatch) -> None:
    start = begun(records({}), QUICK).scored(QUICK)
    evidence, found, seen = Evidence(start.first, [], []), search.as_result(start), [SeenEvent(PUSH, leading=True)]
    monkeypatch.setattr(search, "largest_event", lambda *_, **__: seen.pop() if seen else None)
    monkeypatch.setattr(search, "_set_aside", lambda *_: search.Aside.of(evidence, start, [PUSH]))
    monkeypatch.setattr(search, "_by_each_noise", lambda *_: found)
    monkeypatch.setattr(search, "leaves_only_noise", lambda _: True)
    monkeypatch.setattr(search, "is_fitted", lambda *_: True)
    monkeypatch.setattr(search, "stands_out", too_late)
    result = search._beside_lesser_events(found, search.Aside.of(evidence, start), QUICK, lambda _: None)
    assert (result.late, result.unexamined, result.events) == (True, (search.ONCE,), ())


def test_an_event_whose_deviation_no_time_is_left_to_judge_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search_events, "left_by", too_late)
    made = eventful(PUSH)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=1e6))
    assert [event.record for event in found.events] == ["slow"]


def test_an_event_that_is_set_aside_in_time_is_kept() -> None:
    made = eventful(PUSH)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=1e6))
    assert [(one.record, one.kind) for one in found.events] == [("slow", "bump")]


def test_time_that_ends_wherever_nobody_expects_it_ends_no_diagnosis(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "_searched", too_late)
    made = records(STRIBECK)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=60.0))
    assert (found.verdict, found.causes, found.is_cut_short) == ("unknown", (), True)


def test_refits_count_where_no_time_is_left_for_what_their_effects_become(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refits, "_with_extremes", too_late)
    made = records(STRIBECK)
    found = diagnose(fitted(made), made, QUICK, DiagnosisOptions(budget=60.0))
    assert [cause.effect for cause in found.causes] == ["motor.stribeck"]
    assert "not examined: what effects become at the bounds of their parameters" in found.remarks[0]
