"""Numbers that are rounding, or need no power of ten, are printed so."""

from __future__ import annotations

import pytest

from robotid.numerals import (
    capitalised,
    fixed,
    number,
    percent,
    plain,
    portion,
    probability,
    resolved,
    rms,
    significant,
)


@pytest.mark.parametrize(("value", "text"), [(4.03e-17, "0"), (0.0123, "0.0123"), (None, "-"), (1.5e-9, "1.5e-09")])
def test_an_error_that_is_rounding_is_none(value: float | None, text: str) -> None:
    assert rms(value) == text


@pytest.mark.parametrize(("value", "text"), [(100.0, "100"), (0.0, "0"), (12.34, "12"), (1234.0, "1200")])
def test_shares_need_no_power_of_ten(value: float, text: str) -> None:
    assert significant(value, 2) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (140.4, "140"),
        (1.46e6, "1.46e6"),
        (1.92e5, "192000"),
        (2e-9, "2e-9"),
        (-0.0125, "-0.0125"),
        (-0.0, "0"),
        (None, "-"),
    ],
)
def test_a_message_is_ascii(value: float | None, text: str) -> None:
    assert plain(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(224.0, "220"), (-15400.0, "-15000"), (1.46e6, "1.5e+06"), (2e-9, "2e-09")]
)
def test_a_number_in_a_table_is_written_out_as_far_as_people_read_it(value: float, text: str) -> None:
    assert number(value, 2) == text


@pytest.mark.parametrize(("value", "text"), [(0.0, "<1e-300"), (3e-12, "3e-12"), (1.0, "1"), (None, "-")])
def test_no_probability_is_written_as_zero(value: float | None, text: str) -> None:
    assert probability(value) == text


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (1459932.1, 601.0, "1.45993e+06"),
        (1130.0412, 0.429, "1130.04"),
        (0.0121, 0.004, "0.0121"),
        (-2.0, float("nan"), "-2"),
        (0.0, 1.0, "0"),
        (1.23456789012345, 1e-14, "1.23456789"),
    ],
)
def test_a_value_shows_two_digits_of_its_standard_deviation(value: float, std: float, text: str) -> None:
    assert resolved(value, std) == text


@pytest.mark.parametrize(
    ("share", "decimals", "text", "cell"),
    [
        (0.972, 1, "97.2 %", "97.2"),
        (0.004, 0, "below 1 %", "<1"),
        (0.006, 0, "1 %", "1"),
        (0.0004, 1, "below 0.1 %", "<0.1"),
        (0.0, 0, "0 %", "0"),
        (1e-15, 1, "0.0 %", "0.0"),
    ],
)
def test_a_share_that_is_not_zero_is_never_called_zero(share: float, decimals: int, text: str, cell: str) -> None:
    assert portion(share, decimals) == text
    assert percent(share, decimals) == cell


@pytest.mark.parametrize(
    ("sentence", "text"),
    [
        ("the fit stalled", "The fit stalled"),
        ("motor.coulomb.Fc ended at its bound", "motor.coulomb.Fc ended at its bound"),
    ],
)
def test_the_name_of_a_parameter_has_no_capital(sentence: str, text: str) -> None:
    assert capitalised(sentence) == text


def test_a_number_with_decimals_is_not_written_to_a_hundred_digits() -> None:
    assert [fixed(value) for value in (96.914, -385.0, -1234567.891)] == ["96.91", "-385.00", "-1234567.89"]
    assert [fixed(value) for value in (-1e99, 2.5e7)] == ["-1e+99", "2.5e+07"]
