"""Apache Parquet files, by pyarrow. Structs become dotted names, lists of equal length matrices."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.extra import library
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import LARGEST_EXACT, Table, table

SUFFIXES = (".parquet", ".pq")

BYTES = 8  # of a number
TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def read(path: Path) -> Table:
    """Every numeric column. A `unit` in the metadata of a field is kept; dates and times are seconds from the first.

    Raises InputError for a damaged file, and where pyarrow is not installed.
    """
    library("pyarrow.parquet", "parquet", path)
    try:
        content = _flat(path)
        columns, units, text = _columns(content)
    except InputError:
        raise
    except Exception as error:  # a damaged file makes the parser fail in ways that nobody has listed
        what = "this is not a readable Parquet file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again") from error
    return table(str(path), columns, units, text=text)


def _flat(path: Path) -> Any:
    """The file's table with structs resolved into their fields."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        facts = file.metadata
        require_room(path, "it", facts.num_rows * facts.num_columns * BYTES)
        content = file.read()
    while any(pa.types.is_struct(field.type) for field in content.schema):
        content = content.flatten()
    return content


def _columns(content: Any) -> tuple[dict[str, Array], dict[str, str], dict[str, str]]:
    """Values, units and the first of each text, by name."""
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    text: dict[str, str] = {}
    for field, column in zip(content.schema, content.columns, strict=True):
        values, unit = _values(column)
        if values is not None:
            columns[field.name] = values
            units |= {field.name: unit or _unit(field)} if unit or _unit(field) else {}
        elif isinstance(first := next((item for item in column.to_pylist() if item is not None), None), str):
            text[field.name] = first
    return columns, units, text


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
