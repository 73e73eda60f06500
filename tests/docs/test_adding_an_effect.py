"""The effect that the manual shows is one file: it passes the tests of all effects, and the diagnosis finds it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support.hidden_motor import motor_with
from support.manual.pages import FOLDER, Page
from support.paths import ROOT

(EFFECT,) = Page(FOLDER / "adding-an-effect.md").fenced("python")


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with the file that the page shows."""
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
    (extended / "machine.yaml").write_text(motor_with("eddy_brake", Tb=0.3, vc=4))
    done = python(extended, "robotid", "run", "machine.yaml", "--json")
    assert done.returncode == 0, done.stderr
    (cause,) = json.loads(done.stdout)["diagnose"]["causes"]
    assert cause["effect"] == "motor.eddy_brake"
    assert cause["parameters"]["Tb"]["value"] == pytest.approx(0.3, rel=0.05)
    assert cause["heldout_gain"] > 1
