"""What a time column counts, and the sampling time that it tells, for a person to correct."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robotid.errors import RobotidError
from robotid.model.array import Array
from robotid.signals.columns import Column
from robotid.signals.readers.table import Table
from robotid.signals.sampling import usual_step
from robotid.signals.units import UNITS

GIVE_SAMPLING_TIME = "give sampling_time"
THIS_AGE = (6.3e8, 3.2e9)  # [s] since 1970: 1990 to 2071
EPOCHS = {
    "milliseconds since 1970": (1e-3, 0.0),
    "microseconds since 1970": (1e-6, 0.0),
    "nanoseconds since 1970": (1e-9, 0.0),
    "100 ns since 1601, as Windows does": (1e-7, -11_644_473_600.0),
}
"""How the numbers of a date become seconds since 1970: factor and zero. No number is a date of this age in two."""


def sampling_time(table: Table, column: Column | None, remarks: list[str]) -> float | None:
    """The usual step of a time column [s], None where it tells none; why, is added to the remarks."""
    t = None if column is None else _seconds(table, column)
    h = None if t is None or len(t) < 2 or not np.median(np.diff(t)) > 0 else usual_step(t)
    if h is None:
        remarks.append(f"{_no_time(column, t)}; {GIVE_SAMPLING_TIME}")
    elif h >= 0.5 and column is not None and column.unit is None:
        remarks.append(f"{column.name} steps by {h:g}; give its unit if it does not count seconds")
    return h


def _no_time(column: Column | None, t: Array | None) -> str:
    """Why a column tells no sampling time."""
    if column is None or t is None or len(t) < 2:
        return "no time column was found"
    if not np.ptp(t):
        return f"the time column {column.name} stands still"
    if np.median(np.diff(t)) < 0:
        return f"time runs backward in column {column.name}"
    return f"the time column {column.name} has {len(np.unique(t))} times for {len(t)} samples"


def _seconds(table: Table, column: Column) -> Array | None:
    """The times that a column holds [s], None where it holds none."""
    try:
        t: Array = table.pick(column.name, column.column) * UNITS[column.unit or "s"].factor
    except RobotidError:
        return None
    t = t[np.isfinite(t)]
    return t if column.scale is None else column.scale * t


def dated(table: Table, column: Column, remarks: list[str]) -> Column:
    """A time column without a unit whose numbers are dates counted in other units than seconds, with that unit."""
    t = _seconds(table, column)
    if column.unit is not None or t is None or not len(t):
        return column
    for name, (tick, zero) in EPOCHS.items():
        if THIS_AGE[0] <= tick * float(t[0]) + zero <= THIS_AGE[1]:
            remarks.append(f"{column.name} counts {name}")
            unit = next((u for u in ("ms", "us", "ns") if UNITS[u].factor == tick), None)
            return replace(column, unit=unit, scale=None if unit else tick)
    return column
