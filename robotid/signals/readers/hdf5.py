"""HDF5 files: every numeric dataset of one or two dimensions, groups as dotted names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from robotid.errors import InputError
from robotid.signals.readers.table import Table

SUFFIXES = (".h5", ".hdf5")
DAMAGED = (OSError, RuntimeError, KeyError, ValueError, TypeError)  # whatever h5py raises on a damaged file


def read(path: Path) -> Table:
    """Columns by path, with dots for slashes; an attribute `unit` is kept."""
    try:
        with h5py.File(path, "r") as file:
            found = {name.replace("/", "."): node for name, node in numeric(file)}
            columns = {name: np.squeeze(node[()].astype(np.float64)) for name, node in found.items()}
            units = {name: str(node.attrs["unit"]) for name, node in found.items() if "unit" in node.attrs}
    except DAMAGED as error:
        what = "this is not a readable HDF5 file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again") from error
    return Table(str(path), columns, units)


def numeric(file: h5py.File) -> Iterator[tuple[str, h5py.Dataset]]:
    """Path and dataset of every numeric vector and matrix."""
    names: list[str] = []
    file.visit(names.append)
    for name in names:
        node = file[name]
        if not isinstance(node, h5py.Dataset) or node.dtype.kind not in "fiub":
            continue
        if sum(length > 1 for length in node.shape) in (1, 2):
            yield name, node
