"""One process at a time in a run directory."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from robotid.files import remove_leftovers, touch
from robotid.pipeline.lock import LOCK, locked

HOLD = """
import sys, time
from pathlib import Path
from robotid.pipeline.lock import locked
with locked(Path(sys.argv[1]), "robotid run a.yaml", print):
    print("locked", flush=True)
    time.sleep(float(sys.argv[2]))
"""


def hold(folder: Path, seconds: float) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(folder), str(seconds)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "locked\n"
    return process


def test_a_second_process_waits_and_says_for_whom(tmp_path: Path) -> None:
    remarks: list[str] = []
    with hold(tmp_path, 1.0) as other, locked(tmp_path, "robotid fit a.yaml", remarks.append):
        assert other.poll() is not None or other.wait(5) == 0
        assert (tmp_path / LOCK).read_text() == f"process {os.getpid()}: robotid fit a.yaml\n"
    assert remarks == [f"{tmp_path}: process {other.pid}: robotid run a.yaml works in it; waiting until that ends"]
    assert os.listdir(tmp_path) == []


def test_a_process_that_was_killed_locks_nothing(tmp_path: Path) -> None:
    with hold(tmp_path, 60.0) as other:
        other.kill()
    assert os.listdir(tmp_path) == [LOCK]
    part = tmp_path / f".model.h5.{other.pid}.part"
    part.write_bytes(b"half")
    remarks: list[str] = []
    with locked(tmp_path, "robotid fit a.yaml", remarks.append):
        assert not part.exists()
    assert remarks == []
    assert os.listdir(tmp_path) == []


def test_parts_of_the_living_and_other_files_stay(tmp_path: Path) -> None:
    names = [f".model.h5.{os.getpid()}.part", f".model.h5.{os.getppid()}.part", "model.h5.9999999.part", ".a.part"]
    for name in names:
        (tmp_path / name).write_text("")
    (tmp_path / f".model.h5.{10**30}.part").write_text("")
    remove_leftovers(tmp_path)
    assert sorted(os.listdir(tmp_path)) == sorted(names)


def test_a_folder_that_was_made_for_nothing_goes_again(tmp_path: Path) -> None:
    with locked(tmp_path / "runs" / "a", "robotid fit a.yaml", print):
        assert (tmp_path / "runs" / "a" / LOCK).is_file()
    assert os.listdir(tmp_path) == []


def test_what_cannot_be_locked_is_used_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    with locked(tmp_path / "file" / "a", "robotid fit a.yaml", print):
        pass
    monkeypatch.setattr("robotid.pipeline.lock.fcntl", None)
    with locked(tmp_path, "robotid fit a.yaml", print):
        assert os.listdir(tmp_path) == ["file"]


def test_a_file_that_one_may_only_read_keeps_its_times(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    touch(tmp_path, 1.0)
    assert tmp_path.stat().st_mtime == 1.0
    monkeypatch.setattr("robotid.files.os.utime", refuse)
    touch(tmp_path)
    assert tmp_path.stat().st_mtime == 1.0
