"""A robot of two axes through all stages: what each axis would give by itself, in one run directory."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from integration.test_jobs import untimed
from support.alike import alike
from support.two_axes import write_two_axes

import robotid as rid
from robotid.artifacts.store import load as load_artifact
from robotid.cli.app import main
from robotid.config.load import load_robot
from robotid.errors import ConfigError
from robotid.parallel import pool, working
from robotid.pipeline.execute import execute
from robotid.pipeline.run import runs_of
from robotid.pipeline.table import STAGES

AXES = ("a1", "a2")
UP_TO_VALIDATE = list(STAGES)[: list(STAGES).index("validate") + 1]


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which robot.yaml has run into `out`; not to be written to."""
    folder = tmp_path_factory.mktemp("two_axes")
    write_two_axes(folder)
    assert main(["run", str(folder / "robot.yaml"), "--out", str(folder / "out"), "--quiet"]) == 0
    return folder


@pytest.fixture
def out(finished: Path) -> Path:
    return finished / "out"


def printed(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> Any:
    """The document that a command prints."""
    capsys.readouterr()
    assert main([*arguments, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line that a command fails with as wrong usage."""
    capsys.readouterr()
    assert main(list(arguments)) == 2
    (line,) = capsys.readouterr().err.splitlines()
    return line


@pytest.mark.parametrize("axis", [pytest.param("a1", marks=pytest.mark.slow), "a2"])
def test_an_axis_gives_what_it_gives_as_a_single_joint(axis: str, finished: Path, tmp_path: Path) -> None:
    assert main(["run", str(finished / f"{axis}.yaml"), "--out", str(tmp_path), "--quiet"]) == 0
    for stage in STAGES.values():
        alone = load_artifact(tmp_path / stage.output, stage.type()).content
        among = load_artifact(finished / "out" / stage.output, stage.type(), axis).content
        assert alike(untimed(alone), untimed(among)), stage.name


def test_two_processes_find_what_one_does(finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("loky", reason="processes need loky")
    monkeypatch.setattr(pool, "START_UP", 0.0)
    monkeypatch.setattr(pool, "HAND_OVER", 0.0)
    run = runs_of(load_robot(finished / "robot.yaml"), tmp_path)
    with working(2):
        outcomes = [execute(run, name) for name in UP_TO_VALIDATE]
    for outcome in outcomes:
        stage = STAGES[outcome.stage]
        for axis in AXES:
            one = load_artifact(finished / "out" / stage.output, stage.type(), axis).content
            assert alike(untimed(outcome.contents[axis]), untimed(one)), (stage.name, axis)


def test_documents_are_by_axis(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot, out = str(finished / "robot.yaml"), str(finished / "out")
    everything = printed(capsys, "run", robot, "--out", out)
    assert set(everything) == {"out", "stages", "axes"}
    assert [set(found) for found in everything["axes"].values()] == [{"check", "validate", "diagnose", "extend"}] * 2
    fit = printed(capsys, "fit", robot, "--out", out)
    assert list(fit) == ["axes"]
    assert list(fit["axes"]["a2"]["models"]) == ["m1"]
    assert fit["axes"]["a1"] != fit["axes"]["a2"]
    assert list(printed(capsys, "fit", robot, "--out", out, "--axis", "a2")["axes"]) == ["a2"]
    states = printed(capsys, "status", robot, "--out", out)["axes"]
    assert {entry["state"] for axis in states.values() for entry in axis["stages"].values()} == {"fresh"}
    assert list(printed(capsys, "check", robot, "--out", out)["axes"]) == list(AXES)
    shown = printed(capsys, "show", f"{out}/model.h5")["axes"]
    assert shown["a2"]["content"] == fit["axes"]["a2"]
    assert printed(capsys, "show", f"{out}/model.h5", "--axis", "a2")["axes"] == {"a2": shown["a2"]}


def test_tables_name_the_axis_and_end_with_an_overview(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(finished / "robot.yaml"), "--out", str(finished / "out")]) == 0
    lines = capsys.readouterr().out.splitlines()
    begin = lines.index("Overview")
    assert lines[begin + 1].split("  ")[0] == "axis"
    assert [line.split()[0] for line in lines[begin + 3 : begin + 5]] == list(AXES)
    assert any(line.startswith("a2: ") for line in lines[:begin])


def test_an_axis_that_is_not_there(out: Path, finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = str(finished / "robot.yaml")
    for command in ("fit", "run", "status", "check", "report"):
        assert 'there is no axis "a3"; one of a1, a2' in complaint(capsys, command, robot, "--axis", "a3")
    assert "this robot has a single joint" in complaint(capsys, "fit", str(finished / "a1.yaml"), "--axis", "a1")
    assert 'it holds no axis "a3"; it holds a1, a2' in complaint(capsys, "show", str(out / "flex.h5"), "--axis", "a3")


def test_a_model_is_exported_of_one_axis(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    to = tmp_path / "a2.json"
    assert "it is of several axes: a1, a2; choose one" in complaint(capsys, "export", str(out / "model.h5"), str(to))
    assert main(["export", str(out / "model.h5"), str(to), "--axis", "a2"]) == 0
    inertia = [rid.load(out / "model.h5", axis=axis).values["motor.inertia.J"] for axis in AXES]
    assert [repr(float(value)) in to.read_text() for value in inertia] == [False, True]
    assert main(["export", str(out / "records.h5"), str(tmp_path / "r.csv"), "--axis", "a1", "--record", "day1"]) == 0
    assert "a2" in (tmp_path / "r.csv").read_text().splitlines()[0]


def test_runs_are_compared_by_axis(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(out, tmp_path / "again")
    runs = [str(out), str(tmp_path / "again")]
    found = [printed(capsys, "compare", *runs, "--axis", axis) for axis in AXES]
    assert found[0] != found[1]
    assert "it is of several axes: a1, a2; choose one" in complaint(capsys, "compare", *runs)


def test_the_page_has_an_overview_and_the_sections_of_each_axis(out: Path) -> None:
    page = (out / "report.html").read_text()
    assert len(page) < 5_000_000
    assert [page.count(f'<section class="axis" id="axis-{axis}">') for axis in AXES] == [1, 1]
    assert page.index("<caption>Overview</caption>") < page.index('id="axis-a1"') < page.index('id="axis-a2"')
    names = [part.split('"')[0] for part in page.split(' id="')[1:]]
    assert len(names) == len(set(names)), "identifiers are there once"


def test_the_extended_robot_is_a_configuration(out: Path) -> None:
    axes = load_robot(out / "extended.yaml")
    assert list(axes) == list(AXES)
    assert axes["a1"].config.records[0].files == ("../day1.csv",)


def test_python_has_each_axis(finished: Path, tmp_path: Path) -> None:
    out = finished / "out"
    robot, run = rid.load(finished / "robot.yaml"), rid.load(out)
    assert list(robot) == list(run) == list(AXES)
    assert rid.load(finished / "robot.yaml", axis="a1").records.names == ("day1", "day2")
    fit = rid.load(out, axis="a2").fit
    assert fit.values == run["a2"].fit.values == rid.load(out / "model.h5", axis="a2").values
    assert fit.values != run["a1"].fit.values
    with pytest.raises(ConfigError, match='there is no axis "b"'):
        rid.load(out, axis="b")
    shutil.copy(out / "model.h5", tmp_path)
    assert list(rid.load(tmp_path)) == list(AXES)
