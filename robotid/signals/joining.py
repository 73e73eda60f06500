"""One table of several files that were recorded at the same time, each with time stamps of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.columns import Column, convert, find
from robotid.signals.readers.table import Columns, Deferred, Table


def joined(tables: Sequence[Table]) -> Table:
    """The columns of all tables. Where several have a column of one name, it is called file.name, without suffix.

    Time stamps become seconds, counted alike where they are dates. Raises InputError for a file without them.
    """
    if len(tables) == 1:
        return tables[0]
    stems = [Path(table.path).stem for table in tables]
    if len(set(stems)) < len(stems):
        stems = [Path(table.path).name.replace(".", "_") for table in tables]
    count = Counter(name for table in tables for name in table.columns)
    zero = next((origin for table in tables for origin in table.origins.values()), 0.0)
    columns: dict[str, Array | Deferred] = {}
    units: dict[str, str] = {}
    clocks: dict[str, str] = {}
    for stem, table in zip(stems, tables, strict=True):
        own = _clocks(table)
        called = {name: name if count[name] == 1 else f"{stem}.{name}" for name in table.columns}
        times = {time: convert(table, "t", Column(time)).values for time in set(own.values())}
        for name in table.columns:
            shift = table.origins.get(name, zero) - zero
            if name in times:
                columns[called[name]] = times[name] + shift
            else:
                columns[called[name]] = Deferred(table.shape(name), partial(table.columns.__getitem__, name))
        units |= {called[name]: unit for name, unit in table.units.items() if name in called and name not in times}
        units |= {called[time]: "s" for time in times}
        clocks |= {called[name]: called[time] for name, time in own.items()}
    text = {
        f"{stem}.{name}": cell for stem, table in zip(stems, tables, strict=True) for name, cell in table.text.items()
    }
    return Table(" + ".join(table.path for table in tables), Columns(columns), units, None, text, clocks)


def _clocks(table: Table) -> Mapping[str, str]:
    """The column of time stamps of each column."""
    if table.clocks:
        return table.clocks
    time = find(table, "t")
    if time is None:
        hint = f"files are joined by time: call its time stamps t or time; {table.offer()}"
        raise InputError("there is no time column", where=table.path, hint=hint)
    return dict.fromkeys(table.columns, time.name)
