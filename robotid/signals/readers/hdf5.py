"""HDF5 files: every numeric dataset of one or two dimensions, groups as dotted names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table, numeric, table

SUFFIXES = (".h5", ".hdf5")
DAMAGED = (OSError, RuntimeError, KeyError, ValueError, TypeError)  # whatever h5py raises on a damaged file


def read(path: Path) -> Table:
    """Columns by path, with dots for slashes and for the fields of a compound dataset; an attribute `unit` is kept."""
    try:
        with h5py.File(path, "r") as file:
            found = list(_datasets(file))
    except DAMAGED as error:
        what = "this is not a readable HDF5 file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again") from error
    units = {name: unit for name, _, unit in found if unit}
    return table(str(path), {name: values for name, values, _ in found}, units)


def _datasets(file: h5py.File) -> Iterator[tuple[str, Array, str]]:
    names: list[str] = []
    file.visit(names.append)
    for name in names:
        node = file[name]
        if isinstance(node, h5py.Dataset) and node.dtype.kind in "fiubV" and node.shape:
            unit = node.attrs.get("unit", node.attrs.get("units", ""))
            text = unit.decode() if isinstance(unit, bytes) else str(unit)
            for dotted, values in numeric(name.replace("/", "."), node[()]):
                yield dotted, values, text
