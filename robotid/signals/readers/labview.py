"""LabVIEW measurement files (.lvm): text with a header of keys above the names, and one for every signal.

A file without a column of times tells their step in its header. Where a recording was begun again below the first, the
first is read.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.signals.readers import delimited
from robotid.signals.readers.table import Table

SUFFIXES = (".lvm",)

END = "***End_of_Header***"
TIME = "X_Value"  # as LabVIEW calls its column
CHANNELS = "Channels"  # the first key of the header of a recording
COMMENT = "Comment"  # a column after the signals that rows may leave out


def read(path: Path) -> Table:
    """Columns by name, with the units of the header.

    Raises InputError where there is no such header, and where every signal has times of its own.
    """
    lines = delimited.text(path).replace("\r\n", "\n").split("\n")
    ends = [k for k, line in enumerate(lines) if line.startswith(END)]
    if not ends or ends[-1] + 1 >= len(lines):
        hint = "save it again, or name it after its format"
        raise InputError("this is no measurement file of LabVIEW: its header has no end", where=str(path), hint=hint)
    remarks: tuple[str, ...] = ()
    if len(ends) > 2:
        again = next((k for k in range(ends[1], ends[2]) if lines[k].startswith(CHANNELS)), 0)
        if not again:
            hint = "save each recording in a file of its own"
            raise InputError("the file holds several recordings, each below a header", where=str(path), hint=hint)
        remarks = (f"the first of {len(ends) - 1} recordings is read; the others, from line {again + 1}, are left out",)
        lines, ends = lines[:again], ends[:2]
    head = ends[-1] + 1
    separator = "," if lines[head].count(",") > lines[head].count("\t") else "\t"
    keys = {cells[0]: cells[1:] for cells in (line.split(separator) for line in lines[:head])}
    if _of(keys, "X_Columns") == "Multi":
        hint = "save it with one column of times"
        raise InputError("every signal has a column of times of its own", where=str(path), hint=hint)
    names = [name for name in lines[head].split(separator) if name != COMMENT]
    units = ["s", *keys.get("Y_Unit_Label", [])]
    named = [
        f"{name} [{unit}]" if unit else name for name, unit in zip(names, [*units, *[""] * len(names)], strict=False)
    ]
    body = [separator.join(line.split(separator)[: len(names)]) for line in lines[head + 1 :]]
    # empty lines instead of the header keep the numbers of all others
    table = delimited.parsed(path, "\n".join([*[""] * head, separator.join(named), *body]))
    if TIME in table.columns and not np.isfinite(table.columns[TIME]).any():
        begin, step = (_number(path, keys, key) for key in ("X0", "Delta_X"))
        table = table.with_columns(
            {TIME: np.asarray(begin + step * np.arange(len(table.columns[TIME])), dtype=np.float64)}
        )
    return _with_time(replace(table, remarks=table.remarks + remarks))


def _with_time(table: Table) -> Table:
    """The same with a time that is called so."""
    if TIME not in table.columns:
        return table
    columns = {"time" if name == TIME else name: values for name, values in table.columns.items()}
    units = {"time" if name == TIME else name: unit for name, unit in table.units.items()}
    order = tuple("time" if name == TIME else name for name in table.order)
    return replace(table, columns=columns, units=units, order=order)


def _of(keys: dict[str, list[str]], key: str) -> str:
    """What the header tells of a key, of the first signal."""
    return next(iter(keys.get(key, [])), "")


def _number(path: Path, keys: dict[str, list[str]], key: str) -> float:
    try:
        return float(_of(keys, key).replace(",", "."))
    except ValueError:
        what = f"there is no column of times, and the header has no {key}"
        raise InputError(what, where=str(path), hint="save it with one column of times") from None
