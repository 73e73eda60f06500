"""Units as people read them."""

from __future__ import annotations

from itertools import pairwise

import pytest

from robotid.channels import CHANNELS
from robotid.model.units import sliding, typeset, typeset_unit
from robotid.signals.units import parse
from robotid.terms import TERMS

OF_EFFECTS = sorted({p.unit for effect in (*TERMS.values(), *CHANNELS.values()) for p in effect.parameters})


@pytest.mark.parametrize(
    ("plain", "shown"),
    [
        ("kg m2", "kg m²"),
        ("rad/s2/Nm", "rad/s²/Nm"),
        ("m/s2", "m/s²"),
        ("1/Nm2", "1/Nm²"),
        ("Nm/rad3", "Nm/rad³"),
        ("N s2/m2", "N s²/m²"),
        ("0.0136 +- 0.0077 kg m2 is not distinct from zero.", "0.0136 +- 0.0077 kg m² is not distinct from zero."),
        ("magnitude\n[rad/s2/Nm]", "magnitude\n[rad/s²/Nm]"),
        ("area [m2]", "area [m²]"),
    ],
)
def test_powers_of_units_are_raised(plain: str, shown: str) -> None:
    assert typeset(plain) == shown
    assert typeset(shown) == shown


@pytest.mark.parametrize(
    "text", ["m2", "m0, m1 and m2", "runs/m2", "m2/m3", "s2 and N2", "arm.pose_inertia[m2]", "motor.kg2", "rad2.csv"]
)
def test_names_stay(text: str) -> None:
    assert typeset(text) == text


@pytest.mark.parametrize("unit", [*OF_EFFECTS, *map(sliding, OF_EFFECTS)])
def test_no_unit_of_an_effect_keeps_a_plain_power(unit: str) -> None:
    shown = typeset_unit(unit)
    assert not any(a.isalpha() and b in "23456789" for a, b in pairwise(shown))
    if len(unit) > 2:
        assert typeset(unit) == shown


def test_a_raised_unit_is_read_back() -> None:
    assert parse("kg m²") is parse("kg m2")
