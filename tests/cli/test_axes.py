"""`watch` and `compare` on a robot of two axes: one axis at a time, by its name."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.two_axes import write_two_axes

import robotid as rid
from robotid.cli.app import main
from robotid.report import comparison

CHANGED = 1.3  # times the torque that the second axis needs for the same motion


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """robot.yaml fitted in monday/ and, with another torque of the second axis, in friday/, and day3.csv with that."""
    folder = tmp_path_factory.mktemp("axes")
    write_two_axes(folder)
    fitted(folder, "monday")
    for day in ("day1", "day2"):
        change(folder / f"{day}.csv", folder / f"{day}.csv")
    shutil.copy(folder / "day2.csv", folder / "day3.csv")
    fitted(folder, "friday")
    write_two_axes(folder)
    return folder


def fitted(folder: Path, out: str) -> None:
    for stage in ("collect", "init-rigid", "init-flex", "fit"):
        assert main([stage, str(folder / "robot.yaml"), "--out", str(folder / out), "--quiet"]) == 0


def change(file: Path, to: Path) -> None:
    head, *_ = file.read_text().splitlines()
    values = np.loadtxt(file, delimiter=",", skiprows=1)
    values[:, head.split(",").index("torque_2")] *= CHANGED
    np.savetxt(to, values, "%.9g", ",", header=head, comments="")


def printed(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> Any:
    capsys.readouterr()
    assert main([*arguments, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_an_axis_that_has_changed_alarms_and_the_other_does_not(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    watch = ("watch", str(folder / "robot.yaml"), str(folder / "day3.csv"), "--out", str(folder / "monday"), "--axis")
    still = printed(capsys, *watch, "a1")
    assert still["logs"]["day3"]["state"] == "unchanged"
    other = printed(capsys, *watch, "a2", code=5)
    assert other["logs"]["day3"]["state"] != "unchanged"
    assert other["logs"]["day3"]["p_value"] < 1e-6


def test_watching_needs_the_name_of_an_axis(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    watch = ("watch", str(folder / "robot.yaml"), str(folder / "day3.csv"), "--out", str(folder / "monday"))
    assert main(list(watch)) == 2
    assert "the robot has 2 axes; name one by --axis: a1, a2" in capsys.readouterr().err
    assert main([*watch, "--axis", "a3"]) == 2
    assert "a3" in capsys.readouterr().err


def test_compared_is_an_axis_of_each_run(folder: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    runs = [str(folder / name) for name in ("monday", "friday")]
    same, other = (printed(capsys, "compare", *runs, "--axis", axis) for axis in ("a1", "a2"))
    assert [one["difference"] for one in same["differences"]] == [0.0] * 3
    inertia = next(one for one in other["differences"] if one["parameter"] == "motor.inertia.J")
    assert inertia["differs"]
    value = other["runs"]["monday"]["parameters"]["motor.inertia.J"]["value"]
    assert inertia["difference"] == pytest.approx((CHANGED - 1.0) * value, rel=0.02)
    found = rid.compare(runs, axis="a2")
    assert json.loads(json.dumps(comparison.document(found), default=list)) == other
    page = tmp_path / "page.html"
    assert main(["compare", *runs, "--axis", "a2", "--page", str(page)]) == 0
    assert "motor.inertia.J of friday" in page.read_text()


def test_comparing_needs_the_name_of_an_axis(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = [str(folder / name) for name in ("monday", "friday")]
    for arguments in (["compare", *runs], ["compare", *runs, "--axis", "a3"]):
        assert main(arguments) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "a1, a2" in line
