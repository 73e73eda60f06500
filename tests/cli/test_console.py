"""What goes to stdout, and in which form."""

from __future__ import annotations

import json
import sys
from io import StringIO

import pytest

from robotid.cli.console import print_json, print_message, print_tables
from robotid.numerals import fixed, number
from robotid.report.tables.table import Table


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


def test_units_have_powers_and_names_stay(capsys: pytest.CaptureFixture[str]) -> None:
    rows = (("m2", "m2 is 3 rad/s2 off", "kg m2"), ("m3", "-", "m2"))
    print_tables([Table("Errors of m2 [rad/s2]", ("model", "why", "unit"), rows, "of 2 kg m2")])
    title, _, _, *lines = capsys.readouterr().out.splitlines()
    assert title == "Errors of m2 [rad/s²]"
    found = [tuple(line.split("   ")) for line in lines]
    assert [[cell.strip() for cell in line if cell.strip()] for line in found] == [
        ["m2", "m2 is 3 rad/s² off", "kg m²"],
        ["m3", "-", "m²"],
        ["of 2 kg m²"],
    ]


def test_talk_goes_to_stderr_unless_quiet(capsys: pytest.CaptureFixture[str]) -> None:
    print_message("hello")
    print_message("nobody reads", quiet=True)
    assert capsys.readouterr() == ("", "hello\n")


@pytest.mark.parametrize(("value", "text"), [(None, "-"), (float("nan"), "-"), (1234567.0, "1.235e+06"), (0.5, "0.5")])
def test_number(value: float | None, text: str) -> None:
    assert number(value) == text


def test_fixed() -> None:
    assert (fixed(96.389), fixed(float("inf")), fixed(1.0, 0), fixed(-0.001)) == ("96.39", "-", "1", "0.00")


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def on_terminal(table: Table, monkeypatch: pytest.MonkeyPatch, **environment: str) -> str:
    """A table as a terminal of 56 columns shows it."""
    stream = Terminal()
    for name, value in {"COLUMNS": "56", "NO_COLOR": "", "TERM": "xterm", **environment}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "stdout", stream)
    print_tables([table])
    return stream.getvalue()


def test_a_table_too_wide_for_the_terminal_is_set_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    heads = ("parameter", *(f"m{k}" for k in range(5)), "remark")
    rows = (("motor.inertia.J", *["1.2345e+06"] * 5, "a sentence that may be folded where it must"),)
    shown = on_terminal(Table("Parameters", heads, rows, "a note"), monkeypatch, NO_COLOR="1")
    lines = [line.rstrip() for line in shown.splitlines()]
    assert max(map(len, lines)) <= 56
    assert lines[0] == "Parameters"
    assert lines[-1] == "a note"
    assert sum(line.startswith("parameter") for line in lines) == 3
    assert shown.count("1.2345e+06") == 5, "no number is cut or folded"


def test_words_have_their_colours_unless_none_are_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    table = Table("", ("state",), (("fresh",), ("stale",)), styles={"stale": "yellow"})
    shown = on_terminal(table, monkeypatch)
    assert "\x1b[33mstale" in shown
    assert "\x1b[33mfresh" not in shown
    assert "\x1b" not in on_terminal(table, monkeypatch, NO_COLOR="1")
