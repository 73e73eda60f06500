"""NumPy archives of plain arrays. An array is unpacked when it is asked for; members that are none are passed over."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import Columns, Deferred, Table, floats, numeric_parts, table

SUFFIXES = (".npz",)
MEMBER = ".npy"  # how the name of an array's member ends
DAMAGED = (
    *(OSError, ValueError, EOFError, TypeError, KeyError, SyntaxError, NotImplementedError, RuntimeError),
    *(zipfile.BadZipFile, zlib.error, OverflowError, MemoryError),
)


def read(path: Path) -> Table:
    """Every numeric array of one or two dimensions, fields by dotted name. Nothing is unpickled."""
    try:
        with zipfile.ZipFile(path) as archive:
            columns = dict(column for member in archive.infolist() for column in _columns(path, archive, member))
    except DAMAGED as error:
        raise _damaged(path) from error
    if not columns:
        raise _damaged(path)
    return table(str(path), Columns(columns))


def _damaged(path: Path) -> InputError:
    what = "this is not a readable NumPy archive: foreign, damaged, or with pickled objects"
    return InputError(what, where=str(path), hint="save plain arrays with numpy.savez")


def _columns(path: Path, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Iterator[tuple[str, Deferred]]:
    if not member.filename.endswith(MEMBER):
        return
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        header: Any = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = header(file)
    if dtype.hasobject:  # it can only be unpickled
        return
    for part in numeric_parts(member.filename.removesuffix(MEMBER), dtype, shape):
        size = dtype.itemsize * int(np.prod([*map(float, shape)]))
        yield part.name, Deferred(part.shape, _Reading(path, member.filename, size, part.fields))


class _Reading:
    """Unpacks one array, or one field of it. size : that its header declares [bytes]."""

    def __init__(self, path: Path, member: str, size: int, fields: tuple[str, ...]) -> None:
        self.path, self.member, self.size, self.fields = path, member, size, fields

    def __call__(self) -> Array:
        require_room(self.path, self.member.removesuffix(MEMBER), self.size)
        try:
            with zipfile.ZipFile(self.path) as archive, archive.open(self.member) as file:
                values: Any = np.lib.format.read_array(file, allow_pickle=False)
        except DAMAGED as error:
            raise _damaged(self.path) from error
        for field in self.fields:
            values = values[field]
        return floats(values.squeeze())
