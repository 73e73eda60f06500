"""`make pipeline`: rules that rebuild only what is stale, and do not take for done what is not."""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.paths import ROOT

from robotid.cli.app import main
from robotid.cli.report import make_report
from robotid.config.load import load
from robotid.errors import ThresholdError
from robotid.pipeline.execute import execute_all
from robotid.pipeline.run import Run

CONFIG = """
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - {name: day1, file: data/day1.csv}
validate: {thresholds: {fit_percent: {day1: 90}}}
diagnose: {min_improvement_sigma: 1000}
"""
STAGES = ["collect", "init-rigid", "init-flex", "fit", "validate", "diagnose", "extend", "report"]

Make = Callable[..., tuple[int, list[str], str]]


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Make:
    """Run `make pipeline` in a folder of its own; returns exit code, stages called, and what was said.

    The `robotid` that make calls hands its words to this process, which has everything imported already.
    """
    if shutil.which("make") is None:
        pytest.skip("there is no make here")
    monkeypatch.chdir(tmp_path)
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    environment = tmp_path / "environment"
    (environment / "bin").mkdir(parents=True)
    asked, answer = tmp_path / "asked", tmp_path / "answer"
    os.mkfifo(asked)
    os.mkfifo(answer)
    script = environment / "bin" / "robotid"
    script.write_text(f'#!/bin/sh\necho "$@" > "{asked}"\nread code < "{answer}"\nexit "$code"\n')
    script.chmod(0o755)
    (environment / ".installed").touch()

    def run(*arguments: str) -> tuple[int, list[str], str]:
        command = ["make", "--no-print-directory", "pipeline", f"VENV={environment}", "CONFIG=axis.yaml", *arguments]
        here = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
        ended: list[subprocess.CompletedProcess[str]] = []

        def wait() -> None:
            ended.append(subprocess.run(command, capture_output=True, text=True, env=here, check=False))
            asked.write_text("\n")

        threading.Thread(target=wait, daemon=True).start()
        capsys.readouterr()
        called = []
        while words := asked.read_text().split():
            called.append(words[0])
            answer.write_text(f"{main(words)}\n")
        (done,) = ended
        return done.returncode, called, "".join(capsys.readouterr()) + done.stdout + done.stderr

    return run


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "axis.yaml").write_text(CONFIG)
    (tmp_path / "data").mkdir()
    write_log(tmp_path / "data" / "day1.csv", friction=0.6)
    return tmp_path


def write_log(file: Path, friction: float) -> None:
    t = np.arange(1500) * 0.002
    angle, speed, acceleration = 10 * np.sin(3 * t), 30 * np.cos(3 * t), -90 * np.sin(3 * t)
    torque = 0.012 * acceleration + 0.013 * speed + friction * np.sign(speed)
    noise = np.random.default_rng(1).normal(scale=1e-3, size=(2, len(t)))
    columns = np.column_stack([t, torque + noise[0], angle, speed + noise[1]])
    np.savetxt(file, columns, delimiter=",", header="t,tau_m,phi_m,dphi_m", comments="", fmt="%.9g")


def run(folder: Path) -> None:
    axis = Run(load(folder / "axis.yaml"), folder / "runs" / "axis")
    for _ in execute_all(axis):
        pass
    make_report(axis)


def test_only_what_is_stale(make: Make, folder: Path) -> None:
    run(folder)
    assert make()[:2] == (0, []), "what `robotid run` made is in order"

    (folder / "axis.yaml").write_text("# a remark\n" + CONFIG)
    code, called, said = make()
    assert (code, called) == (0, STAGES), "by time all of it may be stale"
    assert said.count("is fresh") == len(STAGES), "by content none of it is"
    assert make()[:2] == (0, [])

    write_log(folder / "data" / "day1.csv", friction=0.7)
    assert make()[:2] == (0, STAGES)


def test_a_missed_threshold_is_missed_again(make: Make, folder: Path) -> None:
    (folder / "axis.yaml").write_text(CONFIG.replace("90", "99.9999"))
    with pytest.raises(ThresholdError):
        run(folder)
    code, called, said = make()
    assert (code, called) == (2, ["validate"])
    assert "below the 99.9999 % asked" in said


def test_a_missing_file_is_robotids_complaint(make: Make, folder: Path) -> None:
    (folder / "data" / "day1.csv").unlink()
    code, called, said = make()
    assert (code, called) == (2, ["collect"])
    assert "data/day1.csv: there is no such file; a record's file is relative to the configuration" in said
