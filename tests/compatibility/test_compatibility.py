"""The trial installs judge rightly: an environment that is prepared wrongly proves nothing."""

from __future__ import annotations

import json
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

import pytest
from support.paths import ROOT

from compatibility import environment
from compatibility.environment import (
    WEEK,
    Environment,
    PreparationError,
    Side,
    UnsupportedError,
    prepare,
    requirements,
)
from compatibility.interpreters import Interpreter, find_interpreters
from compatibility.outcome import Outcome, State, table
from compatibility.trial import TrialError, try_out

PROJECT: dict[str, Any] = {
    "dependencies": ["numpy>=1.26; python_version < '3.13'", "numpy>=2.1; python_version >= '3.13'", "rich>=13.7"],
    "classifiers": ["Programming Language :: Python :: 3.13"],
}


def test_the_lowest_versions_are_the_bounds_themselves() -> None:
    assert requirements(PROJECT, Side.NEWEST) == PROJECT["dependencies"]
    assert requirements(PROJECT, Side.LOWEST) == [
        "numpy==1.26; python_version < '3.13'",
        "numpy==2.1; python_version >= '3.13'",
        "rich==13.7",
    ]


@pytest.mark.parametrize("dependency", ["numpy", "numpy<3", "numpy>=1.26,<3", "numpy~=1.26"])
def test_a_dependency_without_a_plain_lower_bound_is_refused(dependency: str) -> None:
    with pytest.raises(PreparationError, match="is not of the form name>=version"):
        requirements({"dependencies": [dependency]}, Side.LOWEST)


def test_every_dependency_of_this_project_has_a_lower_bound() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert len(requirements(project, Side.LOWEST)) == len(project["dependencies"]) > 8


def test_this_interpreter_is_found_without_its_environment() -> None:
    (one,) = find_interpreters([sys.executable])
    assert one.numbers == sys.version_info[:3]
    assert one.path == getattr(sys, "_base_executable", sys.executable)
    assert find_interpreters(["no-such-python"]) == []


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    (tmp_path / "pyproject.toml").write_text(
        '[project]\ndependencies = ["numpy>=1.26"]\nclassifiers = ["Programming Language :: Python :: 3.13"]\n'
    )
    return tmp_path


class Installer:
    """Takes the place of pip. installs : how often dependencies were installed; answer : what pip complains of."""

    def __init__(self) -> None:
        self.installs, self.answer = 0, ""

    def __call__(self, command: list[str]) -> str:
        if command[1:3] == ["-m", "venv"]:
            Path(command[3]).mkdir(parents=True)
        if ":all:" in command:
            self.installs += 1
            if self.answer:
                raise PreparationError(self.answer)
        names = [name for name in environment.SHOWN if "list" in command]
        return json.dumps([{"name": name, "version": "1.0"} for name in names])


@pytest.fixture
def installer(monkeypatch: pytest.MonkeyPatch) -> Installer:
    installer = Installer()
    monkeypatch.setattr(environment, "_run", installer)
    return installer


def made(checkout: Path, side: Side, minor: int = 13, patch: int = 0) -> Environment:
    return prepare(checkout, Interpreter((3, minor, patch), "python3"), side, Path("a.whl"), checkout / "kept")


def test_an_environment_is_kept_until_what_it_was_made_from_changes(checkout: Path, installer: Installer) -> None:
    assert not made(checkout, Side.LOWEST).reused
    assert made(checkout, Side.LOWEST).reused
    assert installer.installs == 1
    assert not made(checkout, Side.LOWEST, patch=1).reused
    settings = checkout / "pyproject.toml"
    settings.write_text(settings.read_text().replace("1.26", "2.0"))
    assert not made(checkout, Side.LOWEST, patch=1).reused
    assert installer.installs == 3


def test_the_newest_versions_are_looked_for_again_after_a_week(
    checkout: Path, installer: Installer, monkeypatch: pytest.MonkeyPatch
) -> None:
    for side in Side:
        made(checkout, side)
        assert made(checkout, side).reused
    now = time.time()
    monkeypatch.setattr(time, "time", lambda: now + WEEK + 60)
    assert made(checkout, Side.LOWEST).reused
    assert not made(checkout, Side.NEWEST).reused


def test_a_python_without_wheels_is_skipped_only_where_nothing_is_promised(
    checkout: Path, installer: Installer
) -> None:
    installer.answer = "ERROR: No matching distribution found for numpy>=1.26"
    with pytest.raises(UnsupportedError, match=r"no wheel of numpy>=1\.26 for this Python"):
        made(checkout, Side.NEWEST, minor=19)
    with pytest.raises(PreparationError, match="No matching distribution"):
        made(checkout, Side.NEWEST, minor=13)
    assert not (checkout / "kept" / "3.13-newest" / "made.json").exists(), "what failed is not taken for fresh"


def test_a_command_that_fails_is_a_failure(tmp_path: Path) -> None:
    scripts = tmp_path / "bin"
    scripts.mkdir()
    (scripts / "robotid").write_text("#!/bin/sh\necho something broke >&2\nexit 1\n")
    (scripts / "robotid").chmod(0o755)
    with pytest.raises(TrialError, match="robotid --help: exit code 1: something broke"):
        try_out(Environment("3.13-lowest", tmp_path, {}, False), ROOT / "configs")


def test_the_table_ends_with_the_count() -> None:
    tried = Outcome("3.13.0", "lowest", versions={"numpy": "2.1.0"}, reused=True)
    passed = tried.ended(State.PASSED, seconds={"smoke": 4.25})
    failed = Outcome("3.13.0", "newest").ended(State.FAILED, "robotid --help: exit code 1")
    skipped = Outcome("3.19.0", "newest").ended(State.SKIPPED, "there is no wheel of numpy for this Python")
    head, *rows, reason, why, total = table([passed, failed, skipped]).splitlines()
    assert head.split() == ["Python", "versions", "numpy", "smoke", "[s]", "environment", "outcome"]
    assert rows[0].split() == ["3.13.0", "lowest", "2.1.0", "4.2", "kept", "passed"]
    assert reason == "3.13.0 newest: failed: robotid --help: exit code 1"
    assert why.startswith("3.19.0 newest: skipped: there is no wheel")
    assert total == "1 passed, 1 failed, 1 skipped"
