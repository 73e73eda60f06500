"""What a fit does not confirm is rejected, and all shares still make one."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.diagnosed import NAMED, STRIBECK

from robotid.diagnosis.confirmation import is_idle, without_causes
from robotid.diagnosis.results import Cause


def cause(gain: float) -> Cause:
    return replace(STRIBECK, heldout_gain=gain)


@pytest.mark.parametrize(("gain", "idle"), [(0.001, True), (-0.2, True), (0.01, False), (float("nan"), False)])
def test_a_cause_is_confirmed_by_its_gain_where_there_is_one_to_measure(gain: float, idle: bool) -> None:
    assert is_idle(cause(gain)) == idle


def test_without_its_only_cause_a_large_misfit_is_unknown() -> None:
    one = cause(0.0)
    found = without_causes(replace(NAMED, causes=(one,), remaining_share=1.0 - one.explained), [one])
    assert (found.verdict, found.causes, found.remaining) == ("unknown", (), NAMED.misfit)
    assert found.remaining_share == pytest.approx(1.0)
    assert (found.rejected[0].effect, found.rejected[0].heldout_gain) == (one.effect, 0.0)
    assert "does not confirm" in found.rejected[0].why
    assert all(record.explained_after == pytest.approx(0.0) for record in found.records.values())


def test_without_its_only_cause_a_small_misfit_is_clean() -> None:
    one = cause(0.0)
    little = replace(NAMED, causes=(one,), misfit=0.019, events=(), shape=None)
    assert without_causes(little, [one]).verdict == "clean"
    assert without_causes(replace(little, events=NAMED.events), [one]).verdict == "named"
    assert without_causes(replace(little, shape=NAMED.curves[0]), [one]).verdict == "unknown"


def test_what_a_rejected_cause_explained_is_left() -> None:
    minor = replace(cause(0.0), effect="motor.cogging", explained=0.2)
    first = replace(STRIBECK, explained=0.7)
    found = without_causes(replace(NAMED, causes=(first, minor), remaining_share=0.1), [minor])
    assert found.causes == (first,)
    assert found.remaining_share + sum(one.explained for one in found.causes) == pytest.approx(1.0)
    assert NAMED.remaining < found.remaining < NAMED.misfit
    assert found.verdict == "named"
