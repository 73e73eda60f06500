"""Where errors of the torque lead the simulation of whole records astray, causes are sought in pieces of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pytest
from support.small_bench import DURATION, STRIBECK, fitted, records, references

from robotid.diagnosis import Criteria, Diagnosis, DiagnosisOptions, diagnose, procedure
from robotid.diagnosis.search.data import Evidence
from robotid.diagnosis.search.state import Log, SearchResult, SearchState
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated
from robotid.extension import extend, extension_task
from robotid.interrupt import OutOfTime
from robotid.signals.record import Record

CRITERIA = Criteria(max_causes=1, max_refits=1, skip=("power_friction", "record_change"))


@pytest.fixture
def astray(monkeypatch: pytest.MonkeyPatch) -> None:
    """In whole records nothing shows, and all that is left passes for errors of the torque."""
    search = procedure.search

    def seen(evidence: Evidence, criteria: Criteria, log: Log, begun: SearchState | None = None) -> SearchResult:
        found = search(evidence, criteria, log, begun)
        return found if evidence.horizon is not None else replace(found, causes=(), curve=None)

    monkeypatch.setattr(procedure, "search", seen)
    monkeypatch.setattr(procedure, "lead_astray", lambda _: True)


def diagnosed(hidden: Mapping[str, float], options: DiagnosisOptions | None = None) -> Diagnosis:
    made = records(hidden)
    return diagnose(fitted(made), made, CRITERIA, options)


@pytest.mark.usefixtures("astray")
def test_a_cause_is_found_in_pieces_and_extends_the_model_there() -> None:
    made = records(STRIBECK)
    fit = fitted(made)
    found = diagnose(fit, made, CRITERIA)
    assert [cause.effect for cause in found.causes] == ["motor.stribeck"]
    assert found.horizon == pytest.approx(DURATION / 16, rel=0.01)
    assert any("in pieces of 0.25 s" in remark for remark in found.remarks)
    task = extension_task(found, fit, made)
    assert task.horizon == task.options.horizon == found.horizon
    after = extend(task, ["motor.stribeck"])
    (size,) = (one.value for one in after.fit.parameters if one.name == "motor.stribeck.dFs")
    assert size == pytest.approx(STRIBECK["motor.stribeck.dFs"], rel=0.05)
    assert after.fit.horizon == found.horizon


@pytest.mark.usefixtures("astray")
def test_where_pieces_show_nothing_either_whole_records_count() -> None:
    found = diagnosed({})
    assert (found.verdict, found.horizon) == ("clean", None)
    assert not any("pieces" in remark for remark in found.remarks)


@pytest.mark.usefixtures("astray")
@pytest.mark.parametrize("passes", [False, True])
def test_what_is_unknown_in_pieces_too_stays_as_whole_records_had_it(
    monkeypatch: pytest.MonkeyPatch, *, passes: bool
) -> None:
    """passes : whether all that the whole records leave passes for errors of the torque."""
    search = procedure.search

    def nameless(evidence: Evidence, criteria: Criteria, log: Log, *begun: SearchState) -> SearchResult:
        return replace(search(evidence, criteria, log, *begun), causes=())

    def only_noise(found: SearchResult) -> bool:
        return passes and len(found.last.fitted) == len(references()) - 1

    monkeypatch.setattr(procedure, "search", nameless)
    monkeypatch.setattr(procedure, "leaves_only_noise", only_noise)
    assert (diagnosed(STRIBECK).horizon is not None) == passes


@pytest.mark.usefixtures("astray")
def test_pieces_of_the_fit_are_cut_no_further(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Evidence, "in_pieces", lambda *_: pytest.fail("there is no need"))
    assert diagnosed({}, DiagnosisOptions(horizon=0.5)).horizon is None


@pytest.mark.usefixtures("astray")
def test_pieces_for_which_no_time_was_left_are_said_to_be(monkeypatch: pytest.MonkeyPatch) -> None:
    search = procedure.search

    def in_time_for_whole_records(
        evidence: Evidence, criteria: Criteria, log: Log, *begun: SearchState
    ) -> SearchResult:
        found = search(evidence, criteria, log, *begun)
        return found if evidence.horizon is None else replace(found, causes=(), late=True)

    monkeypatch.setattr(procedure, "search", in_time_for_whole_records)
    found = diagnosed(STRIBECK, DiagnosisOptions(budget=1000.0))
    assert (found.causes, found.horizon) == ((), None)
    assert any("causes that show in pieces" in remark for remark in found.remarks)


@pytest.mark.usefixtures("astray")
def test_pieces_that_no_time_was_left_to_cut_are_said_to_be(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_late(*_: object) -> float:
        raise OutOfTime

    monkeypatch.setattr(procedure, "_length_of_pieces", too_late)
    found = diagnosed(STRIBECK, DiagnosisOptions(budget=1000.0))
    assert found.horizon is None
    assert any("causes that show in pieces" in remark for remark in found.remarks)


@pytest.mark.usefixtures("astray")
def test_pieces_that_cannot_be_simulated_tell_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def impossible(*_: object) -> Evidence:
        raise NumericsError("it runs away", hint="none")

    monkeypatch.setattr(Evidence, "in_pieces", impossible)
    assert diagnosed(STRIBECK).horizon is None


def test_nothing_is_sought_in_pieces_where_the_simulation_stays_with_the_motion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Evidence, "in_pieces", lambda *_: pytest.fail("there is no need"))
    assert diagnosed({}).verdict == "clean"


@pytest.mark.parametrize("unfollowed", [None, "gear.backlash"])
def test_what_no_simulation_of_whole_records_follows_is_sought_in_pieces(
    monkeypatch: pytest.MonkeyPatch, unfollowed: str | None
) -> None:
    search, asked = procedure.search, list[float]()

    def seen(evidence: Evidence, criteria: Criteria, log: Log, begun: SearchState | None = None) -> SearchResult:
        if evidence.horizon is not None:
            asked.append(evidence.horizon)
            raise NumericsError("it runs away", hint="none")
        found = search(evidence, criteria, log, begun)
        return replace(found, causes=tuple(replace(one, unfollowed=unfollowed) for one in found.causes))

    monkeypatch.setattr(procedure, "search", seen)
    assert [cause.effect for cause in diagnosed(STRIBECK).causes] == ["motor.stribeck"]
    assert len(asked) == (unfollowed is not None)


@pytest.mark.parametrize("nearer", [False, True])
def test_a_cause_of_whole_records_gives_way_to_one_that_comes_nearer_in_pieces(
    monkeypatch: pytest.MonkeyPatch, *, nearer: bool
) -> None:
    """The errors that the first cause leaves lead the simulation astray."""
    search, left = procedure.search, procedure._left_in_pieces

    def seen(evidence: Evidence, criteria: Criteria, log: Log, begun: SearchState | None = None) -> SearchResult:
        found = search(evidence, criteria, log, begun)
        return found if evidence.horizon is not None else replace(found, curve=None)

    def misled(evidence: Evidence, found: SearchResult, length: float) -> float:
        whole = len(found.last.fitted) == len(evidence.fitted)
        return left(evidence, found, length) * (2.0 if whole else 1.0)

    monkeypatch.setattr(procedure, "search", seen)
    monkeypatch.setattr(procedure, "lead_astray", lambda _: True)
    monkeypatch.setattr(procedure, "_left_in_pieces", misled if nearer else lambda *_: 1.0)
    found = diagnosed(STRIBECK)
    assert [cause.effect for cause in found.causes] == ["motor.stribeck"]
    assert (found.horizon is not None) == nearer


@pytest.mark.parametrize(("followed", "pieces"), [(1.0, 16), (0.2, 32), (0.1, 64), (0.01, 64)])
@pytest.mark.usefixtures("astray")
def test_pieces_are_as_long_as_the_simulation_stays_with_the_motion(
    monkeypatch: pytest.MonkeyPatch, followed: float, pieces: int
) -> None:
    """followed [s] : over which it does."""
    simulated, asked = procedure.simulate_records, list[float]()

    def short(model: FittedModel, records: Sequence[Record], horizon: float | None = None) -> list[Simulated]:
        monkeypatch.setattr(procedure, "strays", lambda *_: horizon is not None and horizon > followed)
        return simulated(model, records, horizon)

    def cut(_: Evidence, horizon: float) -> Evidence:
        asked.append(horizon)
        raise NumericsError("they are not looked at", hint="none")

    monkeypatch.setattr(procedure, "simulate_records", short)
    monkeypatch.setattr(Evidence, "in_pieces", cut)
    diagnosed({})
    assert asked == [pytest.approx(DURATION / pieces, rel=0.01)]
