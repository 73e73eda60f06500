"""HDF5 files: every numeric dataset of one or two dimensions, groups as dotted names.

A dataset is read when it is asked for. Links of any kind but HDF5's plain ones are passed over, so that nothing leads
in circles or out of the file; a dataset whose values lie in other files is refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import Columns, Deferred, Table, floats, numeric_parts, table

SUFFIXES = (".h5", ".hdf5")
DAMAGED = (OSError, RuntimeError, KeyError, ValueError, TypeError)  # whatever h5py raises on a damaged file
MAX_NODES = 100_000  # groups and datasets


def read(path: Path) -> Table:
    """Columns by path, with dots for slashes and for the fields of a compound dataset; an attribute `unit` is kept."""
    try:
        with h5py.File(path, "r") as file:
            found = list(_datasets(path, file))
    except DAMAGED as error:
        raise _damaged(path) from error
    units = {name: unit for name, _, unit in found if unit}
    return table(str(path), Columns({name: column for name, column, _ in found}), units)


def _damaged(path: Path) -> InputError:
    what = "this is not a readable HDF5 file: foreign or damaged"
    return InputError(what, where=str(path), hint="save it again")


def _datasets(path: Path, file: h5py.File) -> Iterator[tuple[str, Deferred, str]]:
    names: list[str] = []
    file.visit(lambda name: names.append(name) if len(names) < MAX_NODES else name)
    for name in names:
        node = file[name]
        if isinstance(node, h5py.Dataset) and node.dtype.kind in "fiubV" and node.shape:
            unit = node.attrs.get("unit", node.attrs.get("units", ""))
            text = unit.decode() if isinstance(unit, bytes) else str(unit)
            for part in numeric_parts(name.replace("/", "."), node.dtype, node.shape):
                yield part.name, Deferred(part.shape, _Reading(path, name, part.fields)), text


class _Reading:
    """Reads one dataset, or one field of it, from the file."""

    def __init__(self, path: Path, name: str, fields: tuple[str, ...]) -> None:
        self.path, self.name, self.fields = path, name, fields

    def __call__(self) -> Array:
        try:
            with h5py.File(self.path, "r") as file:
                values: Any = values_within(self.path, file[self.name])
        except DAMAGED as error:
            raise _damaged(self.path) from error
        for field in self.fields:
            values = values[field]
        return floats(values.squeeze())


def values_within(path: Path, node: h5py.Dataset) -> Array:
    """The values of a dataset. Raises InputError where they lie outside of the file, or there is no room for them."""
    require_own_values(node, path)
    values: Array = node[()]
    return values


def require_own_values(node: h5py.Dataset, path: Path | None = None) -> None:
    """Raises InputError where the values of a dataset lie outside of the file, by default the one that it was opened
    from, or there is no room for them."""
    path = Path(node.file.filename) if path is None else path
    name = node.name.strip("/").replace("/", ".")
    if node.is_virtual or node.external:
        what = f"the values of {name} lie in another file"
        raise InputError(what, where=str(path), hint="copy them into this one, with h5repack say")
    require_room(path, name, node.size * node.dtype.itemsize)
