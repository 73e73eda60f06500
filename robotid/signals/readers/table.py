"""What every reader returns: columns by name."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import Any

import numpy as np

from robotid.errors import ConfigError, InputError, printable
from robotid.model.array import Array

SHOWN = 12  # names that a message lists
INDEXED = re.compile(r"(.+)\[(\d+)\]")
COUNTED = re.compile(r"(.+?)(?:[.:/]|\((?::,\s*)?)(\d+)\)?")  # how others write a column of a matrix
LARGEST_EXACT = 2**53  # integer up to which a float holds every one


CONTAINERS = (".signals.values", ".values", ".data")
"""Ends of dotted names that say nothing: of what Simulink logs, the name stands before."""


@dataclass(frozen=True, slots=True, eq=False)
class Deferred:
    """A column that is in the file and has not been read. shape : (n,) or of a matrix; load : reads it."""

    shape: tuple[int, ...]
    load: Callable[[], Array]


class Columns(Mapping[str, Array]):
    """Columns by name, each read when it is first asked for. Reading raises InputError where that fails."""

    def __init__(self, columns: Mapping[str, Array | Deferred]) -> None:
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> Array:
        column = self._columns[name]
        if isinstance(column, Deferred):
            column = self._columns[name] = column.load()
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def shape(self, name: str) -> tuple[int, ...]:
        """The shape of a column, without reading it."""
        return self._columns[name].shape

    def replaced(self, others: Mapping[str, Array]) -> Columns:
        """The same columns with others in their place or beside them."""
        return Columns(self._columns | dict(others))


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A file's numeric columns. path : as messages name it; columns : dotted name to (n,) or a matrix; units : by name,
    where the file tells them; lines : (n,) line of the file of each row, where the file has lines; text : columns that
    hold text, and the first of it; clocks : the column that holds a column's time stamps, where the file tells;
    origins : of columns that were dates, the second since 1970 that they count from; order : all names as they stand,
    text too, where the file has an order; remarks : what of the file was left out."""

    path: str
    columns: Mapping[str, Array]
    units: dict[str, str] = field(default_factory=dict)
    lines: Array | None = None
    text: dict[str, str] = field(default_factory=dict)
    clocks: dict[str, str] = field(default_factory=dict)
    origins: dict[str, float] = field(default_factory=dict)
    order: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    def pick(self, name: str, column: int | None = None) -> Array:
        """One column, (n,). column : of a matrix, whichever way it lies; name[3] means the same as name with column 3.

        Raises ConfigError where it is not there.
        """
        stored = self.stored(name)
        if stored != name and column is None:
            return self.pick(stored, int(name[len(stored) + 1 : -1]))
        values = self._find(name)
        if values.ndim == 1:
            if column not in (None, 0):
                hint = "leave out `column`"
                raise ConfigError(f'"{name}" is a single column, not a matrix', where=self.path, hint=hint)
            return values
        rows = values if values.shape[0] < values.shape[1] else values.T
        if column is None:
            what = f'"{name}" is a matrix of {len(rows)} columns'
            raise ConfigError(what, where=self.path, hint=f"say which: {{name: {name}, column: 0}}")
        if column >= len(rows):
            what = f'"{name}" has columns 0 to {len(rows) - 1}, not {column}'
            raise ConfigError(what, where=self.path, hint="columns are counted from 0")
        return np.ascontiguousarray(rows[column])

    def shape(self, name: str) -> tuple[int, ...]:
        """The shape of a column, read only where the file does not tell."""
        return self.columns.shape(name) if isinstance(self.columns, Columns) else self.columns[name].shape

    def with_columns(self, others: Mapping[str, Array]) -> Table:
        """The same table with other columns in the place of its own or beside them."""
        return replace(
            self,
            columns=self.columns.replaced(others) if isinstance(self.columns, Columns) else {**self.columns, **others},
        )

    def stored(self, name: str) -> str:
        """The column that holds what a name means: q for q[3], where q is a matrix."""
        indexed = INDEXED.fullmatch(name)
        return indexed[1] if indexed and name not in self.columns and indexed[1] in self.columns else name

    def clock(self, name: str) -> str | None:
        """The column with the time stamps of what a name means, where the file tells."""
        return self.clocks.get(self.stored(name))

    def at_position(self, name: str) -> str:
        """The name of the column that stands at a position, "2", counted from 0; any other name is its own."""
        order = self.order or tuple(self.columns)
        known = name in self.columns or not name.isdecimal() or int(name) >= len(order)
        return name if known else order[int(name)]

    def _find(self, name: str) -> Array:
        if name in self.columns:
            return self.columns[name]
        if name in self.text:
            what = f'column "{name}" holds text, such as "{self.text[name]}"'
            raise ConfigError(
                what, where=self.path, hint="name a column of numbers; for the time, sampling_time does as well"
            )
        counted = COUNTED.fullmatch(name)
        if counted and counted[1] in self.columns and len(self.shape(counted[1])) == 2:
            hint = f"did you mean {counted[1]}[{counted[2]}]? Columns of a matrix are counted from 0"
            raise ConfigError(f'there is no column "{name}"', where=self.path, hint=hint)
        by_case = {known.lower(): known for known in self.columns}
        close = get_close_matches(name.lower(), by_case, 1, 0.6)
        hint = f"did you mean {by_case[close[0]]}?" if close else self.offer()
        raise ConfigError(f'there is no column "{name}"', where=self.path, hint=hint)

    def offer(self) -> str:
        """What the file holds, for a message."""
        names = [self._offered(name) for name in self.columns]
        return "it holds " + ", ".join(names[:SHOWN]) + (", ..." if len(names) > SHOWN else "")

    def _offered(self, name: str) -> str:
        """A name; of a matrix that of its first column, and of its last."""
        shape = self.shape(name)
        return name if len(shape) == 1 else f"{name}[0] to {name}[{min(shape) - 1}]"

    def where(self, row: int) -> str:
        """A row as a place in the file."""
        return f"{self.path}, sample {row}" if self.lines is None else f"{self.path}:{int(self.lines[row])}"


def numeric(name: str, values: Any) -> Iterator[tuple[str, Array]]:
    """Dotted name and values of what is numeric in an array: itself, or the fields of a structured one.

    Axes of length one are dropped; scalars, text and more than two dimensions are left out.
    """
    if values.dtype.names:
        for part in values.dtype.names:
            yield from numeric(f"{name}.{part}", values[part])
    elif values.dtype.kind in "fiub":
        squeezed = np.squeeze(values)
        if squeezed.ndim in (1, 2) and squeezed.size > 1:
            yield name, floats(squeezed)


@dataclass(frozen=True, slots=True)
class NumericPart:
    """What is numeric in an array. name : dotted; fields : from the array down to it; shape : without axes of length
    one."""

    name: str
    fields: tuple[str, ...]
    shape: tuple[int, ...]


def numeric_parts(
    name: str, dtype: np.dtype[Any], shape: tuple[int, ...], fields: tuple[str, ...] = ()
) -> Iterator[NumericPart]:
    """What `numeric` finds in an array, by its type and shape alone."""
    if dtype.names and dtype.fields is not None:
        for part in dtype.names:
            inner = dtype.fields[part][0]
            yield from numeric_parts(f"{name}.{part}", inner.base, (*shape, *inner.shape), (*fields, part))
    elif dtype.kind in "fiub":
        squeezed = tuple(int(n) for n in shape if n != 1)
        if len(squeezed) in (1, 2) and 0 not in squeezed:
            yield NumericPart(name, fields, squeezed)


def floats(values: Any) -> Array:
    """Numbers as floats. Integers too large for that, nanoseconds since 1970 say, are counted from the first."""
    if values.ndim == 1 and values.dtype.kind in "iu" and max(-int(values.min()), int(values.max())) > LARGEST_EXACT:
        values = values.astype(np.int64) - np.int64(values[0])
    return np.asarray(values, dtype=np.float64)


def table(
    path: str,
    columns: Mapping[str, Array],
    units: Mapping[str, str] | None = None,
    *,
    text: Mapping[str, str] | None = None,
    clocks: Mapping[str, str] | None = None,
) -> Table:
    """A table of arrays. Raises InputError where there is none."""
    if not columns:
        hint = "save plain arrays or structs of them; MATLAB's tables, timetables and timeseries cannot be read"
        raise InputError("the file holds no numeric array of one or two dimensions", where=path, hint=hint)
    shown = {name: printable(name) for name in columns}
    if any(name != as_shown for name, as_shown in shown.items()):  # names that would steer a terminal are written out
        columns = {as_shown: columns[name] for name, as_shown in shown.items()}
        units = {shown.get(name, name): unit for name, unit in (units or {}).items()}
        clocks = {shown.get(name, name): shown.get(clock, clock) for name, clock in (clocks or {}).items()}
    kept = columns if isinstance(columns, Columns) else dict(columns)
    return Table(path, kept, dict(units or {}), None, dict(text or {}), dict(clocks or {}))
