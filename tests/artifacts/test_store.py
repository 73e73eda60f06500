"""An artifact is whole or absent, and a file that is not one is told from one that is."""

from __future__ import annotations

import getpass
import hashlib
import os
import platform
import stat
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NoReturn

import h5py
import numpy as np
import pytest
from support.alike import alike

from robotid import files
from robotid.artifacts import store
from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import count_entries, load, read_header, save
from robotid.errors import InputError
from robotid.model.array import Array
from robotid.model.units import sliding


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    torque: Array = field(metadata={"unit": "Nm"})
    names: tuple[str, ...] = ("motor.inertia.J",)


@dataclass(frozen=True, slots=True)
class Other:
    x: float = 0.0


RESULT = Result(np.random.default_rng(1).normal(size=2000))
MADE = Provenance("fit", "robotid fit a.yaml", {"fit": "{}"}, {"collect": "ab"}, "robot: {}\n", seed=3)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "runs" / "a" / "model.h5"
    save(path, RESULT, MADE)
    return path


def test_content_and_provenance_come_back(file: Path) -> None:
    back = load(file, Result)
    assert alike(back.content, RESULT)
    assert back.provenance == MADE
    assert read_header(file) == back.header


def test_the_digest_is_of_the_content_alone(tmp_path: Path) -> None:
    for name, made in (("a", MADE), ("b", replace(MADE, created="2001-01-01T00:00Z", command="other", seed=None))):
        save(tmp_path / name, RESULT, made)
    save(tmp_path / "c", Result(RESULT.torque + 1e-12), MADE)
    a, b, c = (read_header(tmp_path / name).digest for name in "abc")
    assert a == b != c


def test_units_are_those_of_the_axis(tmp_path: Path) -> None:
    save(tmp_path / "slide.h5", RESULT, MADE, sliding)
    with h5py.File(tmp_path / "slide.h5") as opened:
        assert opened["content/torque"].attrs["unit"] == "N"


def test_neither_user_nor_machine_is_named() -> None:
    said = " ".join(MADE.environment.values())
    assert MADE.environment.keys() == {"python", "platform", "numpy", "scipy", "h5py"}
    assert platform.node() not in said
    assert getpass.getuser() not in said.split()


def test_others_may_read_it_as_any_file(file: Path) -> None:
    plain = file.with_name("plain")
    plain.touch()
    assert stat.S_IMODE(file.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


@pytest.mark.parametrize("failing", ["os.fsync", "os.replace"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_write_that_fails_leaves_the_old_one(
    failing: str, error: BaseException, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = file.read_bytes()

    def fail(*arguments: object) -> NoReturn:
        raise error

    monkeypatch.setattr(files, "os", os_with(failing.removeprefix("os."), fail))
    with pytest.raises((InputError, KeyboardInterrupt)) as caught:
        save(file, Result(np.zeros(5)), MADE)
    if isinstance(error, OSError):
        assert str(caught.value) == (
            f"{file}: cannot be written: No space left on device; "
            "check its folder and the space left, or give another --out"
        )
    assert file.read_bytes() == before
    assert os.listdir(file.parent) == ["model.h5"]


def os_with(name: str, stand_in: object) -> object:
    """The module os with one function replaced, for the store alone."""
    return type("os", (), {"fsync": os.fsync, "replace": os.replace, "getpid": os.getpid} | {name: stand_in})


def test_content_that_cannot_be_kept_leaves_the_old_one(file: Path) -> None:
    before = file.read_bytes()
    with pytest.raises(store.CodecError):
        save(file, Result([1.0, 2.0]), MADE)  # type: ignore[arg-type]
    assert file.read_bytes() == before
    assert os.listdir(file.parent) == ["model.h5"]


def complaint(path: Path, cls: type = Result) -> str:
    with pytest.raises(InputError) as caught:
        load(path, cls)
    assert caught.value.exit_code == 3
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: ")
    return line.removeprefix(f"{path}: ")


def test_missing(tmp_path: Path) -> None:
    assert complaint(tmp_path / "model.h5") == "there is no such file; run the stage that makes it"


def test_a_folder(tmp_path: Path) -> None:
    assert complaint(tmp_path) == "this is a folder; name an artifact in it, such as model.h5"


def test_not_hdf5(tmp_path: Path) -> None:
    (tmp_path / "model.h5").write_text("t,u\n0,1\n")
    expected = "this is not a readable HDF5 file: foreign or damaged; run its stage again"
    assert complaint(tmp_path / "model.h5") == expected


def test_not_ours(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "model.h5", "w") as opened:
        opened["content"] = 1
    expected = "this HDF5 file was not made by robotid; give an artifact of a run directory"
    assert complaint(tmp_path / "model.h5") == expected


def test_another_kind(file: Path) -> None:
    assert complaint(file, Other) == "this holds result, not other; run its stage again"


def test_newer(file: Path) -> None:
    file.write_bytes(file.read_bytes().replace(b"format 2", b"format 99", 1))
    assert complaint(file) == (
        "written in format 99, this version reads 2; install that version of robotid, or run its stage again"
    )


def test_of_the_first_format(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "model.h5", "w") as opened:
        opened.attrs.update({"format": "robotid artifact", "schema": 1})
    expected = "written in format 1, this version reads 2; run its stage again"
    assert complaint(tmp_path / "model.h5") == expected


def test_hdf5_finds_the_content_behind_the_user_block(file: Path) -> None:
    with h5py.File(file) as opened:
        assert opened.userblock_size == 512
        assert np.array_equal(opened["content/torque"][()], RESULT.torque)
    first, second = file.read_bytes()[:512].decode().split("\n")[:2]
    assert first == "robotid artifact, format 2"
    assert second == f"sha256 {hashlib.sha256(file.read_bytes()[512:]).hexdigest()}"


def test_entries_are_counted_without_the_class(file: Path) -> None:
    assert count_entries(file, "names") == 1
    assert count_entries(file, "torque") == 2000
    with pytest.raises(InputError, match="of another version"):
        count_entries(file, "causes")


def test_a_changed_number(file: Path) -> None:
    with h5py.File(file, "r+") as opened:
        opened["content/torque"][7] += 1e-9
    assert complaint(file) == "damaged: the file does not match its checksum; run its stage again"


def test_a_changed_unit(file: Path) -> None:
    with h5py.File(file, "r+") as opened:
        opened["content/torque"].attrs["unit"] = "N"
    assert complaint(file) == "damaged: the file does not match its checksum; run its stage again"


def test_a_class_that_has_changed_since(file: Path) -> None:
    @dataclass(frozen=True)
    class Result:
        speed: float

    assert complaint(file, Result) == "of another version (/content has no speed); run its stage again"


def test_a_changed_provenance(file: Path) -> None:
    with h5py.File(file, "r+") as opened:
        opened["provenance/stage"][()] = "validate"
    assert complaint(file) == "damaged: the file does not match its checksum; run its stage again"


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
def test_cut_short(share: float, file: Path) -> None:
    whole = file.read_bytes()
    file.write_bytes(whole[: int(share * len(whole))])
    assert "damaged" in complaint(file)


def test_no_damage_goes_unnoticed(file: Path) -> None:
    whole, refused = file.read_bytes(), 0
    for at in np.random.default_rng(2).integers(0, len(whole), 120):
        damaged = bytearray(whole)
        damaged[at] ^= 0xFF
        file.write_bytes(bytes(damaged))
        try:
            back = load(file, Result)
        except InputError:
            refused += 1
        else:
            assert alike((back.content, back.provenance), (RESULT, MADE))
    assert refused > 40
