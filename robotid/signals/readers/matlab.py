"""MATLAB files: version 5 by scipy, version 7.3 as the HDF5 that it is. Structs become dotted names."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.hdf5 import DAMAGED, numeric
from robotid.signals.readers.table import Table

SUFFIXES = (".mat",)


def read(path: Path) -> Table:
    """Every numeric variable and field of a struct."""
    try:
        return Table(str(path), dict(_version_73(path) if h5py.is_hdf5(path) else _version_5(path)))
    except (*DAMAGED, MatReadError, NotImplementedError, zlib.error, IndexError, MemoryError, ArithmeticError) as error:
        what = "this is not a readable MATLAB file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again") from error


def _version_73(path: Path) -> Iterator[tuple[str, Array]]:
    """MATLAB stores the transpose; text and empty arrays as numbers that are none; cells under #refs#."""
    with h5py.File(path, "r") as file:
        for name, node in numeric(file):
            told = node.attrs.get("MATLAB_class", b"double")
            if not name.startswith("#") and told != b"char" and not node.attrs.get("MATLAB_empty", 0):
                yield name.replace("/", "."), np.squeeze(node[()].astype(np.float64)).T


def _version_5(path: Path) -> Iterator[tuple[str, Array]]:
    content = loadmat(path, squeeze_me=True, struct_as_record=False)
    return _fields("", {name: value for name, value in content.items() if name and not name.startswith("__")})


def _fields(prefix: str, content: dict[str, Any]) -> Iterator[tuple[str, Array]]:
    for key, value in content.items():
        name = f"{prefix}{key}"
        if hasattr(value, "_fieldnames"):
            yield from _fields(f"{name}.", {f: getattr(value, f) for f in value._fieldnames})
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and value.ndim in (1, 2) and value.size > 1:
            yield name, value.astype(np.float64)
