"""A digest knows all that a group holds, and nothing of how the file holds it."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta

import h5py
import numpy as np
import pytest

from robotid.artifacts.provenance import content_digest, digest, now


def digest_of(fill: Callable[[h5py.Group], object]) -> str:
    with h5py.File("memory", "w", driver="core", backing_store=False) as file:
        fill(file.create_group("content"))
        return content_digest(file["content"])


def plain(group: h5py.Group) -> None:
    group.create_dataset("a", data=np.arange(6.0)).attrs["unit"] = "Nm"
    group.create_dataset("b", data=["x", "yz"], dtype=h5py.string_dtype())
    group.create_dataset("c", data=h5py.Empty("f8"))


def changed(change: Callable[[h5py.Group], object]) -> Callable[[h5py.Group], None]:
    def fill(group: h5py.Group) -> None:
        plain(group)
        change(group)

    return fill


def anew(group: h5py.Group, name: str, data: object) -> None:
    unit = group[name].attrs.get("unit")
    del group[name]
    made = group.create_dataset(name, data=data)
    if unit is not None:
        made.attrs["unit"] = unit


@pytest.mark.parametrize(
    "change",
    [
        lambda g: g["a"].__setitem__(5, 5.5),
        lambda g: g["a"].attrs.__setitem__("unit", "N"),
        lambda g: g["b"].__setitem__(0, "xy"),
        lambda g: g.move("a", "d"),
        lambda g: g.create_group("e"),
        lambda g: anew(g, "a", np.arange(6.0).reshape(2, 3)),
        lambda g: anew(g, "a", np.arange(6.0).view(np.int64)),
        lambda g: anew(g, "b", np.zeros(2)),
        lambda g: anew(g, "c", 0.0),
    ],
)
def test_any_change_of_content_is_another_digest(change: Callable[[h5py.Group], object]) -> None:
    assert digest_of(changed(change)) != digest_of(plain)


def test_order_and_packing_do_not_count() -> None:
    def fill(group: h5py.Group) -> None:
        group.create_dataset("c", data=h5py.Empty("f8"))
        group.create_dataset("b", data=["x", "yz"], dtype=h5py.string_dtype())
        group.create_dataset("a", data=np.arange(6.0), compression="gzip", chunks=(2,)).attrs["unit"] = "Nm"

    assert digest_of(fill) == digest_of(plain)


def test_sha_256_as_others_work_it_out() -> None:
    assert digest(b"abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_time_is_in_utc() -> None:
    assert datetime.now(UTC) - datetime.fromisoformat(now()) < timedelta(seconds=5)
