"""Errors are one line that can be read."""

from __future__ import annotations

from robotid.errors import InputError


def test_an_error_quotes_no_more_than_can_be_read() -> None:
    shown = str(InputError(f"this holds {'x' * 100_000}, not records", where="a.h5", hint="make it again"))
    assert len(shown) < 1100
    assert shown.startswith("a.h5: this holds xxx")
    assert shown.endswith("not records; make it again")
