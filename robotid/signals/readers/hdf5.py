"""HDF5 files: every numeric dataset of one or two dimensions, groups as dotted names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table

SUFFIXES = (".h5", ".hdf5")


def read(path: Path) -> Table:
    """Columns by path, with dots for slashes; an attribute `unit` is kept."""
    try:
        with h5py.File(path, "r") as file:
            columns = dict(walk(file))
            units = {n: str(file[n.replace(".", "/")].attrs["unit"]) for n in columns if "unit" in file[n.replace(".", "/")].attrs}
            return Table(str(path), columns, units)
    except OSError as error:
        raise InputError("this is not a readable HDF5 file: foreign or damaged", where=str(path), hint="save it again") from error


def walk(file: h5py.File) -> Iterator[tuple[str, Array]]:
    """Dotted name and values of every numeric dataset."""
    names: list[str] = []
    file.visit(names.append)
    for name in names:
        node = file[name]
        if name.startswith("#") or not isinstance(node, h5py.Dataset) or node.dtype.kind not in "fiub":
            continue
        values = np.squeeze(node[()].astype(np.float64))
        if values.ndim in (1, 2) and values.size > 1:
            yield name.replace("/", "."), values
