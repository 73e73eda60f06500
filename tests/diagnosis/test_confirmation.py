"""What a fit does not confirm is rejected, and all shares still make one."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.diagnosed import NAMED, PAYLOAD, STRIBECK

from robotid.diagnosis.confirmation import is_idle, without_causes
from robotid.diagnosis.results import Cause


def cause(gain: float, sigmas: float) -> Cause:
    """As a fit has it. sigmas : of its amplitude."""
    parameters = tuple(
        replace(p, value=0.1 * sigmas, std_robust=0.1) if p.name.endswith("dFs") else p for p in STRIBECK.parameters
    )
    return replace(STRIBECK, heldout_gain=gain, parameters=parameters)


@pytest.mark.parametrize(
    ("gain", "sigmas", "idle"),
    [(0.001, 0.7, True), (-0.2, 2.9, True), (0.001, 3.1, False), (0.3, 0.7, False), (float("nan"), 0.7, False)],
)
def test_a_cause_is_confirmed_by_its_gain_or_by_its_size(gain: float, sigmas: float, idle: bool) -> None:
    assert is_idle(cause(gain, sigmas)) == idle


def test_a_change_of_a_record_has_no_amplitude_to_judge() -> None:
    assert not is_idle(replace(PAYLOAD, heldout_gain=0.0))


def test_without_its_only_cause_a_large_misfit_is_unknown() -> None:
    one = cause(0.0, 0.5)
    found = without_causes(replace(NAMED, causes=(one,), remaining_share=1.0 - one.explained), [one])
    assert (found.verdict, found.causes, found.remaining) == ("unknown", (), NAMED.misfit)
    assert found.remaining_share == pytest.approx(1.0)
    assert (found.rejected[0].effect, found.rejected[0].heldout_gain) == (one.effect, 0.0)
    assert "does not confirm" in found.rejected[0].why
    assert all(record.explained_after == pytest.approx(0.0) for record in found.records.values())


def test_without_its_only_cause_a_small_misfit_is_clean() -> None:
    one = cause(0.0, 0.5)
    little = replace(NAMED, causes=(one,), misfit=0.019, events=())
    assert without_causes(little, [one]).verdict == "clean"
    assert without_causes(replace(little, events=NAMED.events), [one]).verdict == "named"


def test_what_a_rejected_cause_explained_is_left() -> None:
    minor = replace(cause(0.0, 0.5), effect="motor.cogging", explained=0.2)
    first = replace(STRIBECK, explained=0.7)
    found = without_causes(replace(NAMED, causes=(first, minor), remaining_share=0.1), [minor])
    assert found.causes == (first,)
    assert found.remaining_share + sum(one.explained for one in found.causes) == pytest.approx(1.0)
    assert NAMED.remaining < found.remaining < NAMED.misfit
    assert found.verdict == "named"
