"""Everything wrong that a configuration may say, with the exact line that a person reads.

Each file under bad/config begins with what is wrong, perhaps a --set option, the exit code and the line on stderr, in
which FILE stands for the path.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from support.paths import ROOT

from robotid.cli.app import main

FOLDER = ROOT / "tests" / "bad" / "config"
FILES = sorted(FOLDER.glob("*.yaml"))


@dataclass(frozen=True)
class Case:
    """What the head of a file expects."""

    arguments: list[str]
    exit_code: int
    line: str


def read(path: Path) -> Case:
    lines = [line.removeprefix("# ") for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("# ")]
    head = dict(line.split(": ", 1) for line in lines[:4] if ": " in line)
    options = ["--set", head["set"]] if "set" in head else []
    return Case(["run", str(path), "--dry-run", *options], int(head["exit"]), head["stderr"].replace("FILE", str(path)))


def test_there_are_many() -> None:
    assert len(FILES) >= 50


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_bad_configuration(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = read(path)
    assert main(case.arguments) == case.exit_code
    out, err = capsys.readouterr()
    assert err == case.line + "\n"
    assert out == ""


@pytest.mark.parametrize("name", ["unknown_effect", "syntax", "set_wrong_type"])
def test_in_a_process_of_its_own(name: str) -> None:
    case = read(FOLDER / f"{name}.yaml")
    done = subprocess.run([sys.executable, "-m", "robotid", *case.arguments], capture_output=True, text=True)
    assert (done.returncode, done.stderr, done.stdout) == (case.exit_code, case.line + "\n", "")


def test_debug_adds_a_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    case = read(FOLDER / "unknown_effect.yaml")
    assert main([*case.arguments, "--debug"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("Traceback")
    assert err.endswith(case.line + "\n")


def test_absent_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "absent.yaml"
    assert main(["run", str(path)]) == 2
    assert capsys.readouterr().err == f"{path}: there is no such file; `robotid new NAME` writes one\n"


def test_folder_for_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"{tmp_path}: cannot be read: Is a directory\n"


def test_not_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "model.h5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n\xff\xfe")
    assert main(["run", str(path)]) == 2
    assert capsys.readouterr().err == f"{path}: this is not UTF-8 text\n"
