"""The README keeps its word: its commands run, its tables are those of the code, its effect is one file."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import yaml
from support.effects_table import README, with_effects

from robotid.cli.app import main
from robotid.config.load import load
from robotid.config.schema import DiagnoseSettings, ExtendSettings, ReportSettings
from robotid.stages.collect import collect
from robotid.stages.excite import excite

ROOT = README.parent
TEXT = README.read_text(encoding="utf-8")
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
LINES = [line for kind, block in FENCE.findall(TEXT) if kind == "sh" for line in block.splitlines()]
SHOWN = [" ".join(shlex.split(line, comments=True)) for line in LINES]
INLINE = re.findall(r"`((?:robotid|make|pip) [^`]+)`", FENCE.sub("", TEXT))
COMMANDS = list(dict.fromkeys([*SHOWN, *INLINE]))
OWN = [command for command in SHOWN if command.startswith("robotid")]  # with one's own data, in order
OTHER = [command for command in INLINE if command.startswith("robotid")]
CONFIGURATION = next(block for kind, block in FENCE.findall(TEXT) if kind == "yaml" and "records:" in block)
SETTINGS = next(block for kind, block in FENCE.findall(TEXT) if kind == "yaml" and "diagnose:" in block)
EFFECT = next(block for kind, block in FENCE.findall(TEXT) if kind == "python")


def of_kind(kind: str) -> list[str]:
    return [command for command in COMMANDS if command.startswith(f"{kind} ")]


MACHINE = """
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - name: log
    excite:
      kind: sum
      sampling_time: 0.002
      of:
        - {kind: multisine, band: [0.5, 10], period: 4, peak: 6, crest_factor: 1.6}
        - {kind: triangle, amplitude: 12, period: 4}
  - name: day2
    role: validate
    excite:
      kind: sum
      sampling_time: 0.002
      of:
        - {kind: multisine, band: [0.5, 8], period: 4, peak: 8, crest_factor: 1.6, seed: 5}
        - {kind: square, amplitude: 5, period: 4}
plant:
  model: {motor: [inertia, viscous, coulomb, %s]}
  parameters: {motor.inertia.J: 0.012, motor.viscous.Fv: 0.013, motor.coulomb.Fc: 0.6, %s}
  controller: {kind: speed, kp: 0.5, ki: 5}
  encoder: {counts_per_rev: 65536}
  noise: {torque: 0.005}
  seed: 1
"""
STRIBECK = ("stribeck", "motor.stribeck.dFs: 0.25, motor.stribeck.vs: 2")
BRAKE = ("eddy_brake", "motor.eddy_brake.Tb: 0.3, motor.eddy_brake.vc: 4")


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with two logs of a motor with Stribeck friction."""
    monkeypatch.chdir(tmp_path)
    machine = tmp_path / "machine.yaml"
    machine.write_text(MACHINE % STRIBECK)
    settings = load(machine).config
    for record in collect(settings, excite(settings), {}).records:
        columns = np.column_stack([record.t, record.tau_m, np.rad2deg(record.phi_m)])
        head = "time [s],torque [Nm],angle [deg]"
        np.savetxt(f"{record.name}.csv", columns, delimiter=",", header=head, comments="", fmt="%.6g")
    return tmp_path


def split(line: str) -> tuple[str, list[float]]:
    """Words and numbers of a line."""
    number = r"\d+(?:\.\d+)?"
    return re.sub(number, "#", line), [float(one) for one in re.findall(number, line)]


def test_what_is_made_from_the_code_is_up_to_date() -> None:
    assert with_effects(TEXT) == TEXT, "run `make readme`"


def test_every_command_is_of_a_kind_that_is_tested() -> None:
    assert {command.split()[0] for command in COMMANDS} == {"robotid", "make", "pip"}
    assert len(OWN) > 10
    assert len(OTHER) > 5


def test_ones_own_data_from_log_to_report(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = {}
    for command in OWN:
        assert main(shlex.split(command)[1:]) == 0, (command, capsys.readouterr().err)
        said[command] = capsys.readouterr()
        if command.startswith("robotid new"):
            (desk / "mine.yaml").write_text(CONFIGURATION)
    assert "motor.stribeck" in said["robotid diagnose mine.yaml"].out
    closing = next(block for kind, block in FENCE.findall(TEXT) if "simulates log to" in block)
    told = dict(map(split, said["robotid run mine.yaml"].err.splitlines()))
    for words, numbers in map(split, closing.splitlines()):
        assert told[words] == pytest.approx(numbers, abs=0.02)
    made = {"mine.yaml", "mine.mat", "signals_log.csv", "validation.png", "figures", "runs/mine/extended.yaml"}
    assert [name for name in made if not (desk / name).exists()] == []
    assert len(list((desk / "figures").glob("*.pdf"))) > 10


@pytest.mark.parametrize("command", OTHER)
def test_commands_in_the_text_are_understood(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = shlex.split(command)[1:]
    configs = [word for word in words if word.startswith("configs/")]
    assert all((ROOT / config).is_file() for config in configs)
    if not configs:
        assert main([words[0], "--help"]) == 0
        options = {word for word in words if word.startswith("--")}
        assert all(option in capsys.readouterr().out for option in options)
        return
    words = [str(ROOT / word) if word in configs else word for word in words]
    code = main([*words, "--dry-run", "--out", str(tmp_path)])
    said = capsys.readouterr().err
    assert code == 0 or "is missing; run `robotid" in said, said


@pytest.mark.parametrize("command", of_kind("make"))
def test_make_knows_its_targets(command: str) -> None:
    if shutil.which("make") is None:
        pytest.skip("there is no make here")
    words = [*shlex.split(command), "--dry-run", f"PYTHON={sys.executable}"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("command", of_kind("pip"))
def test_what_pip_installs_is_declared(command: str) -> None:
    what = shlex.split(command)[2]
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    package, _, extra = what.removesuffix("]").partition("[")
    assert package == "."
    assert not extra or extra in extras


def test_files_that_are_named_exist() -> None:
    named = re.findall(r"`((?:configs|data|robotid|tests)/[\w./]+)`|\]\((\w+/[\w.]+)\)", TEXT)
    missing = [a or b for a, b in named if not (ROOT / (a or b)).exists()]
    assert missing == ["robotid/terms/eddy_brake.py"], "the example alone is not there"


def test_settings_are_all_there_with_their_defaults() -> None:
    shown = yaml.safe_load(SETTINGS)
    sections = {"diagnose": DiagnoseSettings(), "extend": ExtendSettings(), "report": ReportSettings()}
    assert shown == {name: section.model_dump(mode="json") for name, section in sections.items()}


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with the file that the README shows."""
    folder = tmp_path_factory.mktemp("package")
    shutil.copytree(ROOT / "robotid", folder / "robotid", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "robotid" / "terms" / "eddy_brake.py").write_text(EFFECT)
    return folder


def python(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    here = os.environ | {"PYTHONPATH": str(folder)}
    command = [sys.executable, "-m", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=here)


def test_the_shown_effect_passes_the_tests_of_all_effects(extended: Path) -> None:
    tests = str(ROOT / "tests" / "promises")
    done = python(
        extended, "pytest", tests, "-k", "eddy_brake", "-p", "no:cacheprovider", "-c", str(ROOT / "pyproject.toml")
    )
    assert done.returncode == 0, done.stdout
    assert "passed" in done.stdout


def test_the_shown_effect_is_found_where_it_is_hidden(extended: Path) -> None:
    (extended / "machine.yaml").write_text(MACHINE % BRAKE)
    done = python(extended, "robotid.cli", "run", "machine.yaml", "--json")
    assert done.returncode == 0, done.stderr
    (cause,) = json.loads(done.stdout)["diagnose"]["causes"]
    assert cause["effect"] == "motor.eddy_brake"
    assert cause["parameters"]["Tb"]["value"] == pytest.approx(0.3, rel=0.05)
    assert cause["heldout_gain"] > 1
