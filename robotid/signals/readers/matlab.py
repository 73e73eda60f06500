"""MATLAB files: version 4 and 5 by scipy, version 7.3 as the HDF5 that it is.

Structs become dotted names, the entries of cells and struct arrays numbers counted from 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import loadmat

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table, numeric, table

SUFFIXES = (".mat",)
MOST_ENTRIES = 64  # of a cell or struct array that are looked into


def read(path: Path) -> Table:
    """Every numeric variable, field of a struct and entry of a cell."""
    try:
        columns = dict(_modern(path) if h5py.is_hdf5(path) else _classic(path))
    except Exception as error:  # a damaged file makes the parser fail in ways that nobody has listed
        what = "this is not a readable MATLAB file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again") from error
    return table(str(path), columns)


def _classic(path: Path) -> Iterator[tuple[str, Array]]:
    content = loadmat(path, squeeze_me=True, struct_as_record=False)
    for name, value in content.items():
        if isinstance(name, str) and name and not name.startswith("__"):
            yield from _walk(name, value)


def _walk(name: str, value: Any) -> Iterator[tuple[str, Array]]:
    if hasattr(value, "_fieldnames"):
        for key in value._fieldnames:
            yield from _walk(f"{name}.{key}", getattr(value, key))
    elif isinstance(value, np.ndarray) and value.dtype.kind == "O":
        for i, item in enumerate(value.flat[:MOST_ENTRIES]):
            yield from _walk(f"{name}.{i}", item)
    elif isinstance(value, np.ndarray):
        yield from numeric(name, value)


def _modern(path: Path) -> Iterator[tuple[str, Array]]:
    with h5py.File(path, "r") as file:
        members: Mapping[str, Any] = file
        for name, node in members.items():
            if not name.startswith("#"):
                yield from _follow(file, name, node)


def _follow(file: h5py.File, name: str, node: h5py.Group | h5py.Dataset) -> Iterator[tuple[str, Array]]:
    """MATLAB stores columns first, so a matrix arrives transposed; text arrives as numbers, and says so."""
    if isinstance(node, h5py.Group):
        for key, inner in node.items():
            yield from _follow(file, f"{name}.{key}", inner)
    elif node.dtype == h5py.ref_dtype:
        for i, reference in enumerate(np.ravel(node[()])[:MOST_ENTRIES]):
            yield from _follow(file, f"{name}.{i}", file[reference])
    elif node.attrs.get("MATLAB_class", b"double") != b"char" and "MATLAB_empty" not in node.attrs:
        yield from numeric(name, np.transpose(node[()]))
