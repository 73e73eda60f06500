"""Units in the spellings that people use."""

from __future__ import annotations

from math import pi

import pytest

from robotid.errors import ConfigError
from robotid.signals.units import UNITS, parse, unit


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("°", "deg"),
        ("Degrees", "deg"),
        ("Grad", "deg"),
        ("Grad/s", "deg/s"),
        ("deg/sec", "deg/s"),
        ("°/s", "deg/s"),
        ("deg_per_s", "deg/s"),
        ("rad s^-1", "rad/s"),
        ("rad·s⁻¹", "rad/s"),
        ("rad_per_s", "rad/s"),
        ("1/min", "rpm"),
        ("min^-1", "rpm"),
        ("U/min", "rpm"),
        ("N m", "Nm"),
        ("N*m", "Nm"),
        ("N.m", "Nm"),
        ("NM", "Nm"),
        ("µs", "us"),
        ("μs", "us"),
        ("m s^-1", "m/s"),
        ("Volt", "V"),
        ("percent", "%"),
        ("inc", "counts"),
    ],
)
def test_spellings(text: str, name: str) -> None:
    assert parse(text) == UNITS[name]


@pytest.mark.parametrize("name", UNITS)
def test_every_name_means_itself(name: str) -> None:
    assert parse(name) is UNITS[name]


@pytest.mark.parametrize("text", ["", "m/s^2", "x", "motor", "state"])
def test_other_words_are_no_units(text: str) -> None:
    assert parse(text) is None


@pytest.mark.parametrize(
    ("name", "factor"),
    [("deg", pi / 180), ("rpm", 2 * pi / 60), ("rev", 2 * pi), ("mNm", 1e-3), ("Nmm", 1e-3), ("mm", 1e-3)],
)
def test_factors(name: str, factor: float) -> None:
    assert UNITS[name].factor == pytest.approx(factor, rel=1e-15)


def test_an_unknown_unit_is_said() -> None:
    with pytest.raises(ConfigError) as error:
        unit("degs/s", "a.csv, column v")
    assert str(error.value) == 'a.csv, column v: there is no unit "degs/s"; did you mean deg/s?'
