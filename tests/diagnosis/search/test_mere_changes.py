"""A change of one record stands where the model is right elsewhere, and no other record differs nearly as much."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.changed_record import one_that_differs

from robotid.diagnosis.search import mere_changes
from robotid.diagnosis.search.mere_changes import without_mere_changes
from robotid.diagnosis.search.state import SearchResult


def left(found: SearchResult, record: str, times: float) -> SearchResult:
    """The same where the last model leaves so many variances of the noise on a record of the fit."""
    fitted = tuple(
        replace(one, energy=times * len(one.record)) if one.record.name == record else one for one in found.last.fitted
    )
    return replace(found, last=replace(found.last, fitted=fitted))


def test_a_record_that_differs_alone_is_told() -> None:
    found = one_that_differs()
    assert found.coloured is not None
    assert [cause.effect.rpartition(".")[0] for cause in found.causes] == ["record_change.slow.motor.coulomb"]
    assert without_mere_changes(found, found.coloured) is found


@pytest.mark.parametrize(
    ("record", "times", "stands"), [("slow", 50.0, True), ("wide", 50.0, False), ("wide", 3.0, True)]
)
def test_beside_a_model_that_is_wrong_elsewhere_nothing_differs(record: str, times: float, stands: bool) -> None:
    found = left(one_that_differs(), record, times)
    assert found.coloured is not None
    after = without_mere_changes(found, replace(found.coloured, noise_reached=False))
    assert (after.causes == found.causes) == stands
    if not stands:
        assert after.last is found.first
        assert after.rejected[0].why == mere_changes.WRONG_ELSEWHERE
        assert without_mere_changes(found, replace(found.coloured, noise_reached=True)).causes == found.causes


@pytest.mark.parametrize(("share", "stands"), [(0.1, True), (0.5, False)])
def test_what_another_record_asks_for_too_is_no_change_of_one(
    share: float, stands: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = one_that_differs()
    size = found.last.parameters[found.causes[0].effect]
    assert found.coloured is not None
    monkeypatch.setattr(mere_changes, "_asked_for", lambda *_: share * size)
    after = without_mere_changes(found, found.coloured)
    assert (after.causes == found.causes) == stands
    assert stands or "differs as much elsewhere: motor.coulomb.Fc on wide by 50 % of it" in after.rejected[0].why
    beside = replace(found, causes=(replace(found.causes[0], effect="motor.stribeck"), *found.causes))
    assert without_mere_changes(beside, found.coloured) is beside
