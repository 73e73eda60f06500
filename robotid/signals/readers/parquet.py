"""Apache Parquet files, by pyarrow. Structs become dotted names, lists of equal length matrices. A column of plain
numbers is read when it is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.extra import library
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import LARGEST_EXACT, Columns, Deferred, Table, table

SUFFIXES = (".parquet", ".pq")

BYTES = 8  # of a number
TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def read(path: Path) -> Table:
    """Every numeric column. A `unit` in the metadata of a field is kept; dates and times are seconds from the first.

    Raises InputError for a damaged file, and where pyarrow is not installed.
    """
    library("pyarrow.parquet", "parquet", path)
    columns: dict[str, Array | Deferred] = {}
    units: dict[str, str] = {}
    text: dict[str, str] = {}
    with _readable(path):
        import pyarrow.parquet as pq

        with pq.ParquetFile(path) as file:
            facts, schema = file.metadata, file.schema_arrow
        require_room(path, "it", facts.num_rows * facts.num_columns * BYTES)
        twice = len(set(schema.names)) < len(schema.names)
        for field in schema:
            if _is_number(field.type) and not twice:
                columns[field.name] = Deferred((facts.num_rows,), partial(_read_numbers, path, field.name))
                units |= {field.name: _unit(field)} if _unit(field) else {}
        for part, column in _parts(path, None if twice else [name for name in schema.names if name not in columns]):
            values, unit = _values(column)
            if values is not None:
                columns[part.name] = values
                units |= {part.name: unit or _unit(part)} if unit or _unit(part) else {}
            elif isinstance(first := _first(column), str):
                text[part.name] = first
        columns = _in_order(columns, schema.names)
    return table(str(path), Columns(columns), units, text=text)


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Whatever fails is a damaged file: the parser fails in ways that nobody has listed."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        what = "this is not a readable Parquet file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again") from error


def _read_numbers(path: Path, name: str) -> Array:
    """One column of plain numbers, (n,)."""
    import pyarrow.parquet as pq

    with _readable(path), pq.ParquetFile(path) as file:
        return _numbers(file.read(columns=[name]).column(name))


def _parts(path: Path, names: list[str] | None) -> Iterator[tuple[Any, Any]]:
    """Fields and columns of these names, None: of all, structs resolved into their fields."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    if names == []:
        return
    with pq.ParquetFile(path) as file:
        content = file.read(columns=names)
    while any(pa.types.is_struct(field.type) for field in content.schema):
        content = content.flatten()
    yield from zip(content.schema, content.columns, strict=True)


def _is_number(kind: Any) -> bool:
    """Whether a type is a plain number, whose unit it does not tell."""
    import pyarrow as pa

    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind))


def _first(column: Any) -> Any:
    """The first entry that is not null, None where there is none."""
    known = column.drop_null()
    return known[0].as_py() if len(known) else None


def _in_order(columns: Mapping[str, Array | Deferred], names: Sequence[str]) -> dict[str, Array | Deferred]:
    """Columns as their fields stand in the file, the fields of a struct at its place."""
    rank = {name: k for k, name in enumerate(names)}

    def place(name: str) -> int:
        while name not in rank and "." in name:
            name = name.rpartition(".")[0]
        return rank.get(name, len(rank))

    return {name: columns[name] for name in sorted(columns, key=place)}


def _unit(field: Any) -> str:
    """What the field's own metadata say."""
    known: dict[str, str] = {key.decode().lower(): value.decode() for key, value in (field.metadata or {}).items()}
    return known.get("unit", known.get("units", "")).strip()


def _values(column: Any) -> tuple[Array | None, str]:
    """A column as numbers, (n,) or (n, k), and the unit that its type implies; None where it holds none."""
    import pyarrow as pa

    kind, is_a = column.type, pa.types
    if is_a.is_date(kind):
        return _values(column.cast(pa.timestamp("s")))
    if is_a.is_timestamp(kind) or is_a.is_duration(kind) or is_a.is_time(kind):
        ticks = column.cast(pa.int32() if is_a.is_time32(kind) else pa.int64())
        return _numbers(ticks, from_first=True) * TICKS[kind.unit], "s"
    if is_a.is_boolean(kind):
        return _numbers(column.cast(pa.int8())), ""
    if is_a.is_integer(kind) or is_a.is_floating(kind) or is_a.is_decimal(kind):
        return _numbers(column), ""
    if is_a.is_list(kind) or is_a.is_large_list(kind) or is_a.is_fixed_size_list(kind):
        return _matrix(column), ""
    return None, ""


def _numbers(column: Any, *, from_first: bool = False) -> Array:
    """A column as floats, (n,), nan where it is null. Integers too large for that are counted from the first."""
    import pyarrow as pa
    import pyarrow.compute as pc

    known = column.drop_null()
    if pa.types.is_integer(column.type) and len(known):
        extremes = pc.min_max(known).as_py()
        if from_first or max(abs(extremes["min"]), abs(extremes["max"])) > LARGEST_EXACT:
            column = pc.subtract(column, known[0])
    floats = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
    return np.asarray(floats, dtype=np.float64)


def _matrix(column: Any) -> Array | None:
    """Lists that are all of one length, (n, k)."""
    import pyarrow.compute as pc

    lengths = set(pc.list_value_length(column).to_pylist())
    if len(lengths) != 1 or not (width := lengths.pop()):
        return None
    values, _ = _values(pc.list_flatten(column))
    return None if values is None or values.ndim > 1 else values.reshape(-1, width)
