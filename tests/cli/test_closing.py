"""The command to type next, after every stage."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.mistaken_logs import configuration, right_log, write_csv

from robotid.cli.app import main

CLEAN = """\
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - {name: slow, excite: {kind: triangle, amplitude: 20, period: 2, sampling_time: 0.005}}
  - {name: check, role: validate, excite: {kind: triangle, amplitude: 15, period: 1.5, sampling_time: 0.005}}
plant:
  parameters: {motor.inertia.J: 0.01, motor.viscous.Fv: 0.02, motor.coulomb.Fc: 0.5}
  controller: {kind: speed, kp: 0.5, ki: 5}
  noise: {speed: 0.01}
  seed: 1
"""
LACKING = CLEAN.replace("noise:", "model: {motor: [inertia, viscous, coulomb, constant_torque]}\n  noise:").replace(
    "Fc: 0.5}", "Fc: 0.5, motor.constant_torque.tau0: 0.2}"
)
FIRST = ["excite", "collect", "init-rigid", "init-flex", "fit", "validate", "diagnose"]


def following(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The last line that a command says."""
    assert main(list(arguments)) == 0
    return capsys.readouterr().err.splitlines()[-1]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_clean_machine_needs_no_extension(capsys: pytest.CaptureFixture[str]) -> None:
    Path("axis.yaml").write_text(CLEAN)
    said = [following(capsys, stage, "axis.yaml") for stage in FIRST]
    assert said == [f"next: robotid {stage} axis.yaml" for stage in (*FIRST[1:], "report")]
    assert following(capsys, "report", "axis.yaml") == "next: robotid show runs/axis/diagnosis.h5"
    assert following(capsys, "extend", "axis.yaml") == "next: robotid report axis.yaml"
    assert following(capsys, "report", "axis.yaml") == "next: robotid show runs/axis/validation.h5"


def test_measured_files_need_no_excitation(capsys: pytest.CaptureFixture[str]) -> None:
    write_csv(Path("log.csv"), right_log("rigid"))
    Path("axis.yaml").write_text(configuration("rigid", {"estimate": "log.csv"}))
    assert following(capsys, "collect", "axis.yaml") == "next: robotid init-rigid axis.yaml"


def test_a_cause_asks_for_the_extension_and_that_for_its_model(capsys: pytest.CaptureFixture[str]) -> None:
    Path("axis.yaml").write_text(LACKING)
    said = [following(capsys, stage, "axis.yaml") for stage in FIRST]
    assert said[-1] == "next: robotid extend axis.yaml"
    assert following(capsys, "extend", "axis.yaml") == "next: robotid report axis.yaml"
    command = following(capsys, "report", "axis.yaml").removeprefix("next: ")
    assert command == "robotid run runs/axis/extended.yaml --out runs/axis-extended"
    assert main([*command.split()[1:], "--dry-run"]) == 0
