"""The contract of diagnose and extend on the command line, end to end: one JSON document, silence, exit codes."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

import pytest
from support.diagnosed_run import ran

from robotid.cli.app import main

NUMBER, TEXT = (int, float), str
CAUSE = {
    "effect": TEXT,
    "parameters": dict,
    "explained": NUMBER,
    "heldout_gain": NUMBER,
    "p_value": NUMBER,
    "class": list,
    "confounded_with": list,
}
REJECTED = {"effect": TEXT, "explained": NUMBER, "heldout_gain": (*NUMBER, type(None)), "why": TEXT}
DIAGNOSIS = {
    "verdict": TEXT,
    "noise_floor": NUMBER,
    "misfit": NUMBER,
    "unit": TEXT,
    "causes": list,
    "rejected": list,
    "remaining": NUMBER,
    "remaining_share": NUMBER,
    "events": list,
    "limits": dict,
    "shape": (dict, type(None)),
}
EXTENSION = {
    "before": dict,
    "after": dict,
    "gain": dict,
    "heldout": dict,
    "bic_before": NUMBER,
    "bic_after": NUMBER,
    "extended": TEXT,
    "model_before": list,
    "model_after": list,
}


def refuse(constant: str) -> NoReturn:
    raise AssertionError(f"{constant} is printed")


def command(name: str, case: str, *options: str) -> list[str]:
    config, out = ran(case)
    return [name, str(config), "--out", str(out), *options]


def document(name: str, case: str, capsys: pytest.CaptureFixture[str]) -> Any:
    """What a stage prints with --json: one document, and nothing else with --quiet."""
    arguments = command(name, case, "--json", "--quiet")
    capsys.readouterr()
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return json.loads(out, parse_constant=refuse)


def has(found: Mapping[str, Any], contract: Mapping[str, Any]) -> None:
    """Every field of a contract is there, of its type."""
    assert set(contract) <= set(found)
    for name, kind in contract.items():
        assert isinstance(found[name], kind), name
        assert not isinstance(found[name], bool), name


@pytest.mark.parametrize("case", ["named", "clean"])
def test_a_diagnosis_has_every_field(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = document("diagnose", case, capsys)
    has(found, DIAGNOSIS)
    assert found["verdict"] == case
    assert found["unit"] == "rad/s"
    assert found["noise_floor"] == pytest.approx(0.02, rel=0.3)
    assert (found["misfit"] > found["noise_floor"]) is (case == "named")
    assert 0 <= found["remaining"] <= found["misfit"]
    for one in found["rejected"]:
        has(one, REJECTED)
        assert 0 <= one["explained"] <= 1


def test_a_cause_has_every_field(capsys: pytest.CaptureFixture[str]) -> None:
    found = document("diagnose", "named", capsys)
    assert [cause["effect"] for cause in found["causes"]] == ["motor.stribeck"]
    for cause in found["causes"]:
        has(cause, CAUSE)
        assert set(cause["parameters"]) == {"dFs", "vs"}
        for parameter in cause["parameters"].values():
            has(parameter, {"value": NUMBER, "std": NUMBER, "unit": TEXT})
        assert 0.9 < cause["explained"] <= 1
        assert 0 <= cause["p_value"] < 1e-3
        assert cause["class"][0] == cause["effect"]
        assert ("separate_by" in cause) is (len(cause["class"]) > 1)
    assert found["causes"][0]["parameters"]["dFs"]["value"] == pytest.approx(0.15, rel=0.1)


def test_a_clean_model_has_no_cause_and_no_shape(capsys: pytest.CaptureFixture[str]) -> None:
    found = document("diagnose", "clean", capsys)
    assert (found["causes"], found["shape"]) == ([], None)


@pytest.mark.parametrize("case", ["named", "clean"])
def test_an_extension_has_every_field(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = document("extend", case, capsys)
    has(found, EXTENSION)
    records = {"slow", "wide", "check"}
    for moment in ("before", "after"):
        assert set(found[moment]) == {"fit_percent", "rmse"}
        assert all(set(found[moment][key]) == records for key in ("fit_percent", "rmse"))
    for name in records:
        change = found["after"]["fit_percent"][name] - found["before"]["fit_percent"][name]
        assert found["gain"]["fit_percent"][name] == pytest.approx(change)
    assert set(found["heldout"]["fit_percent"]) == {"check"}
    assert set(found["model_after"]) - set(found["model_before"]) == ({"motor.stribeck"} if case == "named" else set())
    assert (found["heldout"]["fit_percent"]["check"] > 0.5) is (case == "named")
    assert (found["bic_after"] < found["bic_before"] - 10) is (case == "named")


@pytest.mark.parametrize("case", ["named", "clean"])
@pytest.mark.parametrize("name", ["diagnose", "extend"])
def test_quiet_is_silent(name: str, case: str, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = command(name, case, "--quiet")
    capsys.readouterr()
    assert main(arguments) == 0
    assert capsys.readouterr() == ("", "")


def test_talk_goes_to_stderr_and_tables_to_stdout(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = command("diagnose", "named")
    capsys.readouterr()
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert "motor.stribeck" in out
    assert "diagnosis.h5 is fresh" in err
    assert "fresh" not in out


@pytest.mark.parametrize(
    ("name", "gone", "maker"), [("diagnose", "model.h5", "fit"), ("extend", "diagnosis.h5", "diagnose")]
)
def test_what_is_missing_is_told_in_one_line(
    name: str, gone: str, maker: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config, out = ran("named")
    copy = Path(shutil.copytree(out, tmp_path / "copy"))
    (copy / gone).unlink()
    capsys.readouterr()
    assert main([name, str(config), "--out", str(copy), "--json"]) == 3
    told, err = capsys.readouterr()
    assert told == ""
    assert err.count("\n") == 1
    assert err.startswith(f"{copy / gone}: is missing; run `robotid {maker} {config}")


@pytest.mark.parametrize(("name", "input_"), [("diagnose", "model.h5"), ("extend", "diagnosis.h5")])
def test_what_is_stale_is_told_in_one_line(name: str, input_: str, capsys: pytest.CaptureFixture[str]) -> None:
    changed = {"model.h5": "fit.max_iterations=7", "diagnosis.h5": "diagnose.min_improvement_sigma=0.2"}[input_]
    arguments = command(name, "named", "--json", "--set", changed)
    capsys.readouterr()
    assert main(arguments) == 3
    told, err = capsys.readouterr()
    assert told == ""
    assert err.count("\n") == 1
    assert f"{ran('named')[1] / input_}: is stale" in err
    assert "; run `robotid " in err


@pytest.mark.parametrize(("name", "input_"), [("diagnose", "model.h5"), ("extend", "diagnosis.h5")])
def test_what_is_damaged_is_told_in_one_line(
    name: str, input_: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config, out = ran("named")
    copy = Path(shutil.copytree(out, tmp_path / "copy"))
    (copy / input_).write_bytes((copy / input_).read_bytes()[:500])
    capsys.readouterr()
    assert main([name, str(config), "--out", str(copy), "--json"]) == 3
    told, err = capsys.readouterr()
    assert told == ""
    assert err.count("\n") == 1
    assert err.startswith(f"{copy / input_}: ")


@pytest.mark.parametrize("name", ["diagnose", "extend"])
@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("extend.effects=[motor.stribek]", 'extend.effects[0]: there is no effect "stribek"; did you mean stribeck?'),
        ("extend.effects=[stribeck]", 'extend.effects[0]: "stribeck" has no port; write it as port.effect'),
        (
            "extend.effects=[moter.stribeck]",
            'extend.effects[0]: there is no port or signal "moter"; did you mean motor?',
        ),
        ("extend.effects=[motor.coulomb]", "extend.effects[0]: motor.coulomb is in the model already"),
        ("extend.effects=[motor.spring]", "extend.effects[0]: spring does not act at motor"),
        (
            "extend.effects=[record_change.sloww.motor.coulomb.Fc]",
            'extend.effects[0]: there is no record "sloww"; did you mean slow?',
        ),
        (
            "extend.effects=[record_change.slow.motor.coulomb.Fv]",
            'extend.effects[0]: the model has no parameter "motor.coulomb.Fv"; did you mean motor.coulomb.Fc?',
        ),
        ("diagnose.model=m7", 'diagnose.model: there is no model "m7"; '),
        ("diagnose.skip=[stribek]", 'diagnose.skip[0]: there is no effect "stribek"; did you mean stribeck?'),
        ("diagnose.skip=[moter.stribeck]", 'diagnose.skip[0]: there is no port or signal "moter"; did you mean motor?'),
        ("diagnose.significance=2", "diagnose.significance: "),
    ],
)
def test_what_cannot_be_asked_for_is_refused(
    name: str, change: str, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = command(name, "named", "--set", change)
    capsys.readouterr()
    assert main(arguments) == 2
    told, err = capsys.readouterr()
    assert (told, err.count("\n")) == ("", 1)
    assert line in err
