"""Artifacts as somebody may make them by hand: any dataset replaced, under a checksum that fits."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from robotid.artifacts.store import BLOCK

Change = Callable[[h5py.Group], None]


def forge(path: Path, change: Change) -> Path:
    """Change an artifact, and give it the checksum of what it then is."""
    image = path.read_bytes()
    body = io.BytesIO(image[BLOCK:])
    with h5py.File(body, "r+") as file:
        change(file)
    text = image[:BLOCK].split(b"sha256")[0] + b"sha256 " + hashlib.sha256(body.getvalue()).hexdigest().encode() + b"\n"
    path.write_bytes(text.ljust(BLOCK, b"\n") + body.getvalue())
    return path


def _retyped(values: np.ndarray) -> object:
    if values.dtype.kind == "O":
        return np.ones(values.shape)
    return values.astype(complex) + 1j if values.dtype.kind in "bif" else values.real > 0


def _deeper(values: np.ndarray) -> object:
    return values.T[..., None] if values.ndim < 2 else values.reshape(-1)


def _filled(value: float) -> Callable[[np.ndarray], object]:
    """Every number is this one, as far as the type of the dataset has it."""

    def fill(values: np.ndarray) -> object:
        if values.dtype.kind not in "biuf":
            return np.full(values.shape, value)
        if values.dtype.kind == "f" or not np.isfinite(value):
            return np.full(values.shape, value, dtype=np.float64)
        return np.full(values.shape, int(np.clip(value, -(2**62), 2**62)), dtype=np.int64)

    return fill


WAYS: dict[str, Callable[[np.ndarray], object]] = {
    "remove": lambda values: None,
    "truncate": lambda values: values[: len(values) // 2] if values.ndim else None,
    "lengthen": lambda values: np.concatenate([values, values, values[:1]]) if values.ndim else values.reshape(1),
    "transpose": _deeper,
    "retype": _retyped,
    "words": lambda values: np.full(values.shape, "nothing", dtype=object),
    "nan": _filled(np.nan),
    "inf": _filled(np.inf),
    "negative": _filled(-1.0),
    "zero": _filled(0.0),
    "huge": _filled(1e300),
}
"""What may be done to the values of a dataset; None removes it."""


def datasets(path: Path, *, arrays: bool = False) -> list[str]:
    """The names of all datasets in the content of an artifact that hold anything. arrays : only of those that are."""
    names: list[str] = []
    with h5py.File(path, "r") as file:
        file["content"].visititems(
            lambda name, node: (
                names.append(name)
                if isinstance(node, h5py.Dataset) and (node.shape if arrays else node.shape is not None)
                else None
            )
        )
    return names


def altered(name: str, way: str) -> Change:
    """A dataset of the content altered in one of the ways."""

    def change(file: h5py.Group) -> None:
        node = file["content"][name]
        words = h5py.check_string_dtype(node.dtype) is not None
        made = WAYS[way](np.asarray(node.asstr()[()] if words else node[()], dtype=object if words else None))
        kept = dict(node.attrs)
        del file["content"][name]
        if made is not None:
            values = np.asarray(made)
            kind = h5py.string_dtype() if values.dtype.kind == "O" else None
            file["content"].create_dataset(name, data=values, dtype=kind).attrs.update(kept)

    return change


def attributes(path: Path) -> list[tuple[str, str]]:
    """The names of all groups and datasets in the content of an artifact, each with the name of an attribute of it."""
    names: list[tuple[str, str]] = []
    with h5py.File(path, "r") as file:
        content = file["content"]
        names += [(".", key) for key in content.attrs]
        content.visititems(lambda name, node: names.extend((name, key) for key in node.attrs))
    return names


def altered_attribute(name: str, key: str, way: str) -> Change:
    """An attribute of a group or dataset of the content altered in one of the ways."""

    def change(file: h5py.Group) -> None:
        node = file["content"][name]
        value = node.attrs[key]
        made = WAYS[way](np.asarray(value, dtype=object if isinstance(value, str) else None))
        del node.attrs[key]
        if made is not None:
            values = np.asarray(made)
            node.attrs.create(key, values, dtype=h5py.string_dtype() if values.dtype.kind == "O" else None)

    return change
