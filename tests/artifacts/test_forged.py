"""Artifacts that somebody made by hand, with the right checksum: what they hold is bounded, their own, and named."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import BLOCK, count_entries, load, read_header, save
from robotid.errors import InputError
from robotid.model.array import Array

MADE = Provenance("fit", "robotid fit a.yaml", {}, {}, "robot: {}\n")


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    name: str
    torque: Array = field(metadata={"unit": "Nm"})
    units: tuple[str, ...] = ("Nm",)


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    parts: tuple[Part, ...]
    by_name: dict[str, float]


def forged(path: Path, change: Callable[[h5py.Group], None]) -> Path:
    """An artifact whose content was changed, under a checksum that fits."""
    result = Result((Part("set1", np.arange(3.0)),), {"set1": 1.0})
    save(path, result, MADE)
    head, body = path.read_bytes()[:BLOCK], path.with_suffix(".body")
    body.write_bytes(path.read_bytes()[BLOCK:])
    with h5py.File(body, "r+") as file:
        change(file["content"])
    image = body.read_bytes()
    text = head.split(b"sha256")[0] + b"sha256 " + hashlib.sha256(image).hexdigest().encode() + b"\n"
    path.write_bytes(text.ljust(BLOCK, b"\n") + image)
    return path


def test_unchanged_it_loads(tmp_path: Path) -> None:
    assert load(forged(tmp_path / "a.h5", lambda content: None), Result).content.by_name == {"set1": 1.0}


@pytest.mark.parametrize("name", ["<img src=x>", 'a" onload="b', "a\x1b[31m", "a\nb", "`a`", "a&amp;"])
def test_names_that_are_none(name: str, tmp_path: Path) -> None:
    def rename(content: h5py.Group) -> None:
        del content["parts/0/name"]
        content["parts/0"].create_dataset("name", data=name, dtype=h5py.string_dtype())

    def rename_key(content: h5py.Group) -> None:
        content["by_name"].move("set1", name.replace("/", "%2F"))

    for change in (rename, rename_key):
        with pytest.raises(InputError, match="is no name") as caught:
            load(forged(tmp_path / "a.h5", change), Result)
        assert str(caught.value).isprintable()


def test_units_that_are_none(tmp_path: Path) -> None:
    for unit in ("Nm\x1b[31m", "<b>Nm</b>", "N" * 5000):

        def write(content: h5py.Group, unit: str = unit) -> None:
            del content["parts/0/units"]
            content["parts/0"].create_dataset("units", data=["Nm", unit], dtype=h5py.string_dtype())

        with pytest.raises(InputError, match="is no name") as caught:
            load(forged(tmp_path / "a.h5", write), Result)
        assert str(caught.value).isprintable()


def replaced(content: h5py.Group, make: Callable[[h5py.Group], object]) -> None:
    del content["parts/0/torque"]
    make(content["parts/0"])


def test_values_and_links_that_lead_elsewhere(tmp_path: Path) -> None:
    secret = tmp_path / "secret.txt"
    secret.write_bytes(bytes(24))

    def external(group: h5py.Group) -> None:
        group.create_dataset("torque", (3,), "f8", external=[(str(secret), 0, 24)])

    def virtual(group: h5py.Group) -> None:
        layout = h5py.VirtualLayout((3,), "f8")
        layout[:] = h5py.VirtualSource(str(secret), "a", (3,))
        group.create_virtual_dataset("torque", layout)

    def huge(group: h5py.Group) -> None:
        group.create_dataset("torque", (2**37,), "f8", chunks=(1024,))

    def soft(group: h5py.Group) -> None:
        group["torque"] = h5py.SoftLink("/content/by_name/set1")

    def outside(group: h5py.Group) -> None:
        group["torque"] = h5py.ExternalLink(str(secret), "a")

    cases = {external: "in another file", virtual: "in another file", huge: "declares", soft: "link", outside: "link"}
    for make, message in cases.items():
        path = forged(tmp_path / "a.h5", lambda content, make=make: replaced(content, make))  # type: ignore[misc]
        with pytest.raises(InputError, match=message):
            load(path, Result)


def test_a_tuple_that_is_longer_than_it_is(tmp_path: Path) -> None:
    def lengthen(content: h5py.Group) -> None:
        content["parts"].attrs["length"] = 2**60

    path = forged(tmp_path / "a.h5", lengthen)
    with pytest.raises(InputError, match="has 1 entries"):
        load(path, Result)
    assert count_entries(path, "parts") == 2**60


@pytest.mark.parametrize("length", [1 + 1j, 1.0, "1", [1]])
def test_a_length_that_is_no_whole_number(length: object, tmp_path: Path) -> None:
    def state(content: h5py.Group) -> None:
        content["parts"].attrs["length"] = length

    path = forged(tmp_path / "a.h5", state)
    for read in (lambda: load(path, Result), lambda: count_entries(path, "parts")):
        with pytest.raises(InputError, match="states no length"):
            read()


@pytest.mark.parametrize("created", ["", "yesterday", "9" * 40, "2001-01-01T00:00"])
def test_an_artifact_that_was_made_at_no_time(created: str, tmp_path: Path) -> None:
    save(tmp_path / "a.h5", Result((), {}), replace(MADE, created=created))
    with pytest.raises(InputError, match="which is no time"):
        read_header(tmp_path / "a.h5")
