"""MATLAB files: version 5 by scipy, version 7.3 as the HDF5 that it is. Structs become dotted names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.hdf5 import walk
from robotid.signals.readers.table import Table

SUFFIXES = (".mat",)


def read(path: Path) -> Table:
    """Every numeric variable and field of a struct."""
    if h5py.is_hdf5(path):
        with h5py.File(path, "r") as file:
            return Table(str(path), {name: value.T if value.ndim == 2 else value for name, value in walk(file)})
    try:
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    except (MatReadError, ValueError, TypeError, OSError, NotImplementedError, KeyError) as error:
        raise InputError("this is not a readable MATLAB file: foreign or damaged", where=str(path), hint="save it again") from error
    return Table(str(path), dict(_fields("", {k: v for k, v in content.items() if not k.startswith("__") and k})))


def _fields(prefix: str, content: dict[str, Any]) -> Iterator[tuple[str, Array]]:
    for key, value in content.items():
        name = f"{prefix}{key}"
        if hasattr(value, "_fieldnames"):
            yield from _fields(f"{name}.", {f: getattr(value, f) for f in value._fieldnames})
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and value.ndim in (1, 2) and value.size > 1:
            yield name, value.astype(np.float64)
