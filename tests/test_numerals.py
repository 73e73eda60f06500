"""Numbers that are rounding, or need no power of ten, are printed so."""

from __future__ import annotations

import pytest

from robotid.numerals import plain, rms, significant


@pytest.mark.parametrize(("value", "text"), [(4.03e-17, "0"), (0.0123, "0.0123"), (None, "-"), (1.5e-9, "1.5e-09")])
def test_an_error_that_is_rounding_is_none(value: float | None, text: str) -> None:
    assert rms(value) == text


@pytest.mark.parametrize(("value", "text"), [(100.0, "100"), (0.0, "0"), (12.34, "12"), (1234.0, "1200")])
def test_shares_need_no_power_of_ten(value: float, text: str) -> None:
    assert significant(value, 2) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(140.4, "140"), (1.46e6, "1.46e6"), (1.92e5, "192000"), (2e-9, "2e-9"), (-0.0125, "-0.0125"), (None, "-")],
)
def test_a_message_is_ascii(value: float | None, text: str) -> None:
    assert plain(value) == text
