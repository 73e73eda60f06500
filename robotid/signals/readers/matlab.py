"""MATLAB files: version 4 and 5 by scipy, version 7.3 as the HDF5 that it is.

Structs become dotted names, the entries of cells and struct arrays numbers counted from 0, or what their own field Name
says, as dSPACE writes it.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np
from scipy.io import loadmat

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.hdf5 import values_within
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import CONTAINERS, Columns, Deferred, Table, floats, numeric, numeric_parts, table

SUFFIXES = (".mat",)
MOST_ENTRIES = 64  # of a cell or struct array that are looked into
MAX_DEPTH = 32  # of structs and cells in each other
MAX_NODES = 20_000  # groups and datasets of a file of version 7.3
HEADER = 128  # [bytes] before the first variable of version 5
ORDERS = {b"IM": "<", b"MI": ">"}  # of bytes, as the end of that header tells
PRECISIONS = (8, 4, 4, 2, 2, 1)  # [bytes] of a number of version 4
BLOCK = 2**20  # [bytes] that are unpacked at once to be counted
COMPRESSED = 15  # how version 5 marks a variable that is packed


def read(path: Path) -> Table:
    """Every numeric variable, field of a struct and entry of a cell.

    Of version 7.3 a column is read when it is asked for. Raises InputError for a damaged file, and where it declares
    more than there is room for.
    """
    try:
        columns = Columns(dict(_modern(path) if h5py.is_hdf5(path) else _classic(path)))
    except InputError:
        raise
    except Exception as error:  # a damaged file makes the parser fail in ways that nobody has listed
        raise _damaged(path) from error
    return table(str(path), columns, clocks=_clocks(columns))


def _clocks(columns: Columns) -> dict[str, str]:
    """The time stamps of what Simulink logs: a struct of time and data, as of a timeseries, or of time and
    signals.values."""
    ends = {name: next((end for end in CONTAINERS if name.lower().endswith(end)), "") for name in columns}
    stored = {name.lower(): name for name in columns}
    times = {name: stored.get(f"{name[: -len(end)]}.time".lower(), "") for name, end in ends.items() if end}
    found = {name: time for name, time in times.items() if time and columns.shape(time)[-1] > 1}
    return found if len(set(found.values())) > 1 else {}


def _damaged(path: Path) -> InputError:
    what = "this is not a readable MATLAB file: foreign or damaged"
    return InputError(what, where=str(path), hint="save it again")


def _classic(path: Path) -> Iterator[tuple[str, Array]]:
    require_room(path, "it", _declared_size(path))
    content = loadmat(path, squeeze_me=True, struct_as_record=False)
    for name, value in content.items():
        if isinstance(name, str) and name and not name.startswith("__"):
            yield from _walk(name, value)


def _declared_size(path: Path) -> int:
    """What the variables of a file take [bytes] once they are unpacked: as their headers declare in version 4, and in
    version 5 as the tags of packed variables do. Raises InputError where a packed variable holds more than its tag
    declares, for the parser believes what is in it."""
    with path.open("rb") as file:
        order = ORDERS.get(file.read(HEADER)[-2:])
        if order is None:
            return _declared_by_version_4(path, file)
        total, end = 0, path.stat().st_size
        while file.tell() + 8 <= end:
            kind, size = struct.unpack(f"{order}2I", file.read(8))
            following = file.tell() + size
            if kind == COMPRESSED:
                declared = struct.unpack(f"{order}2I", zlib.decompressobj().decompress(file.read(min(size, 1024)), 8))[
                    1
                ]
                file.seek(following - size)
                require_room(path, "it", total + declared)
                if not _holds(file, size, declared + 8):
                    raise InputError("a variable holds more than it declares", where=str(path), hint="save it again")
                total += declared
            file.seek(following)
    return total


def _holds(file: BinaryIO, size: int, declared: int) -> bool:
    """Whether so many packed bytes of a file unpack to no more than is declared; nothing of it is kept."""
    unpacking, unpacked, left = zlib.decompressobj(), 0, size
    while not unpacking.eof:
        packed = unpacking.unconsumed_tail or file.read(min(left, BLOCK))
        if not packed:
            break
        left -= 0 if unpacking.unconsumed_tail else len(packed)
        unpacked += len(unpacking.decompress(packed, BLOCK))
        if unpacked > declared:
            return False
    return True


def _declared_by_version_4(path: Path, file: BinaryIO) -> int:
    """Bytes of all matrices of a file of version 4, 0 where it is none. A header is five numbers: MOPT (order of bytes,
    0, precision, kind), rows, columns, whether there is an imaginary part, and the length of the name."""
    total, end = 0, path.stat().st_size
    file.seek(0)
    while file.tell() + 20 <= end:
        header = file.read(20)
        order = "<" if struct.unpack("<I", header[:4])[0] < 5000 else ">"
        kind, rows, columns, imaginary, name = struct.unpack(f"{order}5I", header)
        precision = kind // 10 % 10
        if kind >= 5000 or precision >= len(PRECISIONS) or name > end:
            return 0
        size = PRECISIONS[precision] * rows * columns * (1 + bool(imaginary))
        total += size
        file.seek(file.tell() + name + size)
    return total


def _walk(name: str, value: Any, depth: int = 0) -> Iterator[tuple[str, Array]]:
    if depth > MAX_DEPTH:
        return
    if hasattr(value, "_fieldnames"):
        for key in value._fieldnames:
            inner = getattr(value, key)
            called = _own_name(inner)
            yield from _walk(f"{name}.{key}.{called}" if called else f"{name}.{key}", inner, depth + 1)
    elif isinstance(value, np.ndarray) and value.dtype.kind == "O":
        entries = list(value.flat[:MOST_ENTRIES])
        own = [_own_name(item) for item in entries]
        named = all(own) and len({*own}) == len(own)
        for i, item in enumerate(entries):
            yield from _walk(f"{name}.{own[i] if named else i}", item, depth + 1)
    elif isinstance(value, np.ndarray):
        yield from numeric(name, value)


def _own_name(item: Any) -> str:
    """What a struct of Name and Data is called there, without the blocks that it is in; empty for any other."""
    name = getattr(item, "Name", "") if {"Name", "Data"} <= {*getattr(item, "_fieldnames", ())} else ""
    return name.rsplit("/", 1)[-1].strip(' "').replace(".", "_") if isinstance(name, str) else ""


def _modern(path: Path) -> Iterator[tuple[str, Deferred]]:
    with h5py.File(path, "r") as file:
        found = _Walk(path, file)
        for name in file:
            if not name.startswith("#"):
                yield from found.follow(name, file.get(name, getlink=True), file, name, ())


class _Walk:
    """A walk through a file of version 7.3 that ends, whatever leads back to where it has been."""

    def __init__(self, path: Path, file: h5py.File) -> None:
        self.path, self.file, self.nodes = path, file, 0

    def follow(
        self, name: str, link: Any, parent: h5py.Group, key: str | h5py.Reference, above: tuple[int, ...]
    ) -> Iterator[tuple[str, Deferred]]:
        """Columns below one entry of a group. MATLAB stores columns first, so a matrix arrives transposed; text arrives
        as numbers, and says so. Links that lead out of the file, or to a name, are not MATLAB's. above : places of
        the nodes that this one is in."""
        self.nodes += 1
        if not isinstance(link, h5py.HardLink | type(None)) or len(above) > MAX_DEPTH or self.nodes > MAX_NODES:
            return
        node = parent[key]
        place = h5py.h5o.get_info(node.id).addr
        if place in above:
            return
        above = (*above, place)
        if isinstance(node, h5py.Group):
            for inner in node:
                yield from self.follow(f"{name}.{inner}", node.get(inner, getlink=True), node, inner, above)
        elif node.dtype == h5py.ref_dtype:
            entries = np.ravel(values_within(self.path, node))[:MOST_ENTRIES]
            for i, reference in enumerate(entries):
                yield from self.follow(f"{name}.{i}", None, self.file, reference, above)
        elif node.attrs.get("MATLAB_class", b"double") != b"char" and "MATLAB_empty" not in node.attrs:
            for part in numeric_parts(name, node.dtype, node.shape[::-1]):
                yield part.name, Deferred(part.shape, _Reading(self.path, node.name, part.fields))


class _Reading:
    """Reads one dataset of a file of version 7.3, or one field of it."""

    def __init__(self, path: Path, name: str, fields: tuple[str, ...]) -> None:
        self.path, self.name, self.fields = path, name, fields

    def __call__(self) -> Array:
        try:
            with h5py.File(self.path, "r") as file:
                values: Any = np.transpose(values_within(self.path, file[self.name]))
        except InputError:
            raise
        except Exception as error:  # as above
            raise _damaged(self.path) from error
        for field in self.fields:
            values = values[field]
        return floats(values.squeeze())
