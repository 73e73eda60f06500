"""The command check, and that a run stops before anything is fitted to records that make no sense."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.mistaken_logs import configuration, right_log, write_csv

from robotid.cli.app import main
from robotid.signals.plausibility import Axis, Plausibility, check_records
from robotid.signals.quality import Recordings


@pytest.fixture
def wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A configuration of a log whose torque has the wrong sign, in the current folder."""
    monkeypatch.chdir(tmp_path)
    log = right_log("rigid")
    write_csv(tmp_path / "log.csv", log | {"tau_m": -log["tau_m"]})
    (tmp_path / "axis.yaml").write_text(configuration("rigid", {"estimate": "log.csv"}))
    return "axis.yaml"


def test_check_prints_a_table_and_one_line(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", wrong]) == 4
    shown = capsys.readouterr()
    assert "torque_sign" in shown.out
    assert "scale: -1" in shown.out
    (line,) = [line for line in shown.err.splitlines() if "wrong sign" in line]
    assert line.startswith("estimate: torque and motion ask for an inertia of -0.012 kg m2")
    assert line.endswith("`check: {accept: [torque_sign]}` or --accept torque_sign accepts it")


def test_check_as_json(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", wrong, "--json"]) == 4
    document = json.loads(capsys.readouterr().out)
    assert document["meaningful"] is False
    assert document["records"] == ["estimate"]
    (found,) = document["findings"]
    assert set(found) == {"record", "check", "severity", "accepted", "what", "consequence", "cure"}
    assert (found["check"], found["severity"], found["accepted"]) == ("torque_sign", "fatal", False)


@pytest.mark.parametrize("accept", [["--accept", "torque_sign"], ["--set", "check.accept=[torque_sign]"]])
def test_what_is_accepted_does_not_stop(wrong: str, accept: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", wrong, *accept]) == 0
    shown = capsys.readouterr()
    assert "accepted" in shown.out
    assert "next: robotid run axis.yaml" in shown.err


def test_a_run_stops_before_anything_is_fitted(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", wrong]) == 4
    assert "one of them has the wrong sign" in capsys.readouterr().err.splitlines()[-1]
    assert sorted(path.name for path in Path("runs/axis").iterdir()) == [
        ".robotid.check",
        "excitation.h5",
        "records.h5",
    ]


@pytest.mark.parametrize("stage", ["init-rigid", "fit"])
def test_a_single_stage_stops_as_a_run_does(wrong: str, stage: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["collect", wrong, "--quiet"]) == 0
    assert main([stage, wrong]) == 4
    (line,) = capsys.readouterr().err.splitlines()
    assert "one of them has the wrong sign" in line
    assert sorted(path.name for path in Path("runs/axis").iterdir()) == [".robotid.check", "records.h5"]


def test_a_single_stage_goes_on_where_the_finding_is_accepted(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["collect", wrong, "--quiet"]) == 0
    assert main(["init-rigid", wrong, "--accept", "torque_sign"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("check: estimate: torque and motion ask for an inertia of -0.012")
    assert lines[0].endswith("(accepted)")
    assert main(["init-rigid", wrong]) == 0  # up to date: nothing is computed from the records


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Recordings]:
    """The recordings that the checks are asked about, one entry each time."""
    found = list[Recordings]()

    def counted(recordings: Recordings, axis: Axis) -> Plausibility:
        found.append(recordings)
        return check_records(recordings, axis)

    monkeypatch.setattr("robotid.pipeline.check.check_records", counted)
    return found


def test_records_are_checked_once_for_all_stages(wrong: str, asked: list[Recordings]) -> None:
    assert main(["collect", wrong, "--quiet"]) == 0
    for _ in range(2):  # and what was accepted before is not accepted for good
        assert main(["init-rigid", wrong, "--quiet"]) == 4
        assert main(["init-rigid", wrong, "--quiet", "--force", "--accept", "torque_sign"]) == 0
        Path("runs/axis/rigid.h5").unlink()
    assert len(asked) == 1
    assert main(["check", wrong, "--quiet"]) == 4
    assert len(asked) == 2  # whoever asks for a check gets one


@pytest.mark.parametrize("change", ["damaged", "gear ratio", "records"])
def test_what_a_check_found_before_does_not_count_for_others(wrong: str, asked: list[Recordings], change: str) -> None:
    assert main(["run", wrong, "--quiet"]) == 4
    if change == "damaged":
        file = Path("runs/axis/.robotid.check")
        file.write_bytes(file.read_bytes()[:-7])
    options = {
        "gear ratio": ["--set", "robot.gear_ratio=0.5"],
        "records": ["--set", "records.0.columns.tau_m={name: tau_m, scale: -1}"],
    }
    main(["run", wrong, "--quiet", *options.get(change, [])])
    assert len(asked) == 2


def test_a_run_that_stops_prints_its_findings_as_json(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", wrong, "--json"]) == 4
    document = json.loads(capsys.readouterr().out)
    assert document["out"] == "runs/axis"
    assert [finding["check"] for finding in document["check"]["findings"]] == ["torque_sign"]


def test_a_run_lists_the_findings_as_json(finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", finished, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["check"] == {"meaningful": True, "records": ["slow"], "findings": []}


def test_a_speed_in_degrees_is_a_finding_that_may_be_accepted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    log = right_log("rigid")
    write_csv(tmp_path / "log.csv", log | {"dphi_m": np.rad2deg(log["dphi_m"])})
    (tmp_path / "axis.yaml").write_text(configuration("rigid", {"estimate": "log.csv"}))
    assert main(["check", "axis.yaml"]) == 4
    line = capsys.readouterr().err.splitlines()[-1]
    assert "the speed is 57.3 times the derivative of the angle: degrees against radians" in line
    assert main(["check", "axis.yaml", "--accept", "speed_scale"]) == 0


def test_a_check_that_does_not_exist(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", wrong, "--accept", "torque_sing"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == (
        '--accept: there is no check "torque_sing"; did you mean torque_sign?'
    )
    assert main(["check", wrong, "--set", "check.accept=[torque_sing]"]) == 2
    assert 'there is no check "torque_sing"; did you mean torque_sign?' in capsys.readouterr().err


def test_records_that_make_sense(finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", finished]) == 0
    shown = capsys.readouterr()
    assert "nothing was found in slow" in shown.out
    assert "1 record checked: nothing was found" in shown.err
    assert main(["run", finished]) == 0
