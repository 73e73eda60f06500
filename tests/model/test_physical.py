"""Where a parameter makes sense, by what the records offer."""

from __future__ import annotations

from math import inf, pi

import pytest

from robotid.model.physical import Physical, PortRange
from robotid.terms import TERMS

OFFERED = PortRange(duration=100.0, speed=5.0, travel=4 * pi)


@pytest.mark.parametrize(
    ("physical", "limits"),
    [
        (Physical("x", least=10.0, of_duration=0.2), (20.0, inf)),
        (Physical("x", least=30.0, of_duration=0.2), (30.0, inf)),
        (Physical("x", least=2.0, of_duration=0.2, enough=10.0), (10.0, inf)),
        (Physical("x", least=2.0, of_duration=0.05, enough=10.0), (5.0, inf)),
        (Physical("x", within_speed=True), (0.0, 5.0)),
        (Physical("x", within_travel=True), (0.0, 4 * pi)),
        (Physical("x", periods=3.0), (1.5, inf)),
        (Physical("x", bends=2 * pi), (0.5, inf)),
    ],
)
def test_the_range_follows_the_motion(physical: Physical, limits: tuple[float, float]) -> None:
    assert physical.range(OFFERED) == pytest.approx(limits)


def test_without_travel_nothing_is_periodic() -> None:
    assert Physical("x", periods=3.0).range(PortRange(1.0, 0.0, 0.0))[0] == inf


def test_the_range_is_stated_in_words() -> None:
    assert Physical("x", least=10.0, of_duration=0.2).text == "at least 10, at least 0.2 of the longest record"
    assert Physical("x", of_duration=0.2, enough=10.0).text == "at least 0.2 of the longest record or 10"
    assert Physical("x", periods=3.0).text == "the motion covers at least 3 periods"


def test_whatever_counts_periods_must_be_covered() -> None:
    counted = [p for term in TERMS.values() for p in term.parameters if p.turns]
    assert len(counted) >= 3
    assert all(p.physical is not None and p.physical.periods >= 3.0 for p in counted)
