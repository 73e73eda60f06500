"""A file is whole or as it was."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

import robotid
from robotid.errors import InputError
from robotid.files import atomic_write


def test_text_and_bytes_in_a_folder_that_is_made(tmp_path: Path) -> None:
    file = tmp_path / "a" / "b" / "c.txt"
    atomic_write(file, "ä\n")
    assert file.read_bytes() == b"\xc3\xa4\n"
    atomic_write(file, b"\x00", durable=False)
    assert file.read_bytes() == b"\x00"
    assert os.listdir(file.parent) == ["c.txt"]


def test_a_folder_that_is_a_file_is_named_with_the_hint(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("")
    with pytest.raises(InputError, match=r"a/b\.txt: cannot be written: .*; give another folder$"):
        atomic_write(tmp_path / "a" / "b.txt", "", hint="give another folder")


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_what_fails_leaves_the_old_file_alone(
    error: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")

    def fail(*arguments: object) -> None:
        raise error

    monkeypatch.setattr("robotid.files.os.replace", fail)
    with pytest.raises((InputError, KeyboardInterrupt)):
        atomic_write(file, "new")
    assert file.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_files_are_replaced_in_one_place() -> None:
    package = Path(robotid.__file__).parent
    replacing = re.compile(r"os\.replace\(|\.fsync\(|shutil\.move\(|mkstemp\(")
    found = [file.name for file in package.rglob("*.py") if replacing.search(file.read_text(encoding="utf-8"))]
    assert found == ["files.py"]
