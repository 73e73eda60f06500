"""What tests of the command line share."""

from __future__ import annotations

import shutil
from contextlib import chdir
from pathlib import Path

import pytest
from support.paths import CONFIGS
from support.small_axis import CONFIG

from robotid.cli.app import main

SMOKE = CONFIGS / "smoke.yaml"


@pytest.fixture(scope="session")
def run_directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The configuration that CI runs, taken through all stages once; not to be written to."""
    out = tmp_path_factory.mktemp("smoke")
    assert main(["run", str(SMOKE), "--out", str(out), "--quiet"]) == 0
    return out


@pytest.fixture(scope="session")
def finished_axis(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with axis.yaml and runs/axis, taken through all stages once; not to be written to."""
    folder = tmp_path_factory.mktemp("axis")
    (folder / "axis.yaml").write_text(CONFIG)
    with chdir(folder):
        assert main(["run", "axis.yaml", "--quiet"]) == 0
    return folder


@pytest.fixture
def finished(finished_axis: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The configuration of an axis whose stages have all run, in a copy of the folder that is the current one."""
    shutil.copytree(finished_axis, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return "axis.yaml"
