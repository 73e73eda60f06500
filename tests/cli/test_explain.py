"""explain tells all that an effect declares, whatever the effect."""

from __future__ import annotations

import json

import pytest

from robotid.catalogue import EFFECTS
from robotid.cli.app import main
from robotid.model.describe import describe
from robotid.model.units import typeset_unit


@pytest.mark.parametrize("name", EFFECTS)
def test_everything_declared_is_told(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", name]) == 0
    out = capsys.readouterr().out
    told = describe(EFFECTS[name])
    for fact in (name, told.formula, told.source, told.signature, *told.ports):
        assert fact in out
    for p in told.parameters:
        assert p.meaning in out
        assert typeset_unit(p.unit) in out


@pytest.mark.parametrize("name", EFFECTS)
def test_json(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", name, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["effect"] == name
    assert list(document["parameters"]) == [p.symbol for p in EFFECTS[name].parameters]


@pytest.mark.parametrize("name", ["arm.coulomb", "arm.coulomb.Fc"])
def test_a_place_and_a_parameter_may_be_named(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", name]) == 0
    assert capsys.readouterr().out.startswith("coulomb\n")


def test_all_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain"]) == 0
    out = capsys.readouterr().out
    assert [name for name in EFFECTS if f"\n{name} " not in out] == []


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("columb", 'explain: there is no effect "columb"; did you mean coulomb?'),
        ("motor.spring_cubik", 'explain: there is no effect "spring_cubik"; did you mean cubic_spring?'),
        ("gear.coulomb", "explain: coulomb does not act at gear; it acts at motor, arm, tool"),
        ("zzz", 'explain: there is no effect "zzz"; `robotid explain` lists them all'),
    ],
)
def test_what_is_not_there(name: str, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", name]) == 2
    assert capsys.readouterr() == ("", line + "\n")
