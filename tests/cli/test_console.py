"""What goes to stdout, and in which form."""

from __future__ import annotations

import json

import pytest

from robotid.cli.console import Table, fixed, number, print_json, print_tables, say


def test_numbers_that_are_not_finite_are_null(capsys: pytest.CaptureFixture[str]) -> None:
    print_json({"a": float("nan"), "b": [1.5, float("inf")], "c": {"d": (None, True, "nan", 3)}})
    out = capsys.readouterr().out
    assert json.loads(out) == {"a": None, "b": [1.5, None], "c": {"d": [None, True, "nan", 3]}}
    assert "NaN" not in out


def test_a_table_in_a_file_is_plain_and_never_folded(capsys: pytest.CaptureFixture[str]) -> None:
    long = "word " * 60 + "end"
    print_tables([Table("[Title]", ("name", "value [rad]"), (("a", "1.5"), (long, "-20")), "a note")])
    out, err = capsys.readouterr()
    assert err == ""
    assert "\x1b" not in out
    lines = out.splitlines()
    assert lines[0] == "[Title]"
    assert "value [rad]" in lines[1]
    assert lines[3].endswith("1.5")
    assert lines[4].startswith(long)
    assert lines[4].endswith("-20")
    assert lines[5] == "a note"
    assert all(line == line.rstrip() for line in lines)


def test_talk_goes_to_stderr_unless_quiet(capsys: pytest.CaptureFixture[str]) -> None:
    say("hello")
    say("nobody hears", quiet=True)
    assert capsys.readouterr() == ("", "hello\n")


@pytest.mark.parametrize(("value", "text"), [(None, "-"), (float("nan"), "-"), (1234567.0, "1.235e+06"), (0.5, "0.5")])
def test_number(value: float | None, text: str) -> None:
    assert number(value) == text


def test_fixed() -> None:
    assert (fixed(96.389), fixed(float("inf")), fixed(1.0, 0), fixed(-0.001)) == ("96.39", "-", "1", "0.00")
