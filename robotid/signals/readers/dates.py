"""Dates and times of day, as text tables write them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array

MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "--"}
FIRST = 60  # cells that tell whether a column has days
DATE = re.compile(
    r"(?:(?P<day>\d{4}-\d\d-\d\d|\d{4}/\d\d/\d\d|\d\d\.\d\d\.\d{4})[T ]|(?=\d\d:\d\d:))"
    r"(?P<clock>\d\d:\d\d(?::\d\d)?)(?:[.,](?P<part>\d{1,9}))?\s?(?P<zone>Z|[+-]\d\d:?\d\d)?$"
)
"""A day and a time, or a time with its seconds alone. 01/05/2024 is none: it has two meanings."""


def seconds_of(path: Path, cells: Sequence[str], rows: Sequence[int]) -> tuple[float, Array]:
    """The second since 1970 of the first date, and seconds from it (n,), nan where a cell is empty. A date without a
    zone is taken for one in UTC. Raises InputError for a cell that is no date."""
    ticks = np.full(len(cells), np.iinfo(np.int64).min, dtype=np.int64)
    with_day = any((first := DATE.match(cell)) and first["day"] for cell in cells[:FIRST])
    for k, cell in enumerate(cells):
        if cell.lower() in MISSING or cell == "NaT":
            continue
        found = DATE.match(cell)
        try:
            ticks[k] = _nanoseconds(found) if found and bool(found["day"]) is with_day else _fail(cell)
        except ValueError:
            hint = "write all dates alike, such as 2024-05-01 12:00:00.125"
            raise InputError(f'"{cell}" is not a date', where=f"{path}:{rows[k] + 1}", hint=hint) from None
    known = ticks > np.iinfo(np.int64).min
    if not known.any():
        raise InputError("no date is known", where=str(path), hint="give sampling_time instead of a time column")
    zero = int(ticks[known][0] // 10**9) * 10**9
    seconds = np.full(len(cells), np.nan)
    seconds[known] = (ticks[known] - zero) * 1e-9
    return zero * 1e-9, seconds


def _fail(cell: str) -> int:
    raise ValueError(cell)


def _nanoseconds(found: re.Match[str]) -> int:
    """A date in nanoseconds since 1970, a time alone since midnight. Raises ValueError where there is no such date."""
    day = (found["day"] or "1970-01-01").replace("/", "-")
    day = day if "." not in day else "-".join(reversed(day.split(".")))
    clock = found["clock"] if found["clock"].count(":") == 2 else found["clock"] + ":00"
    whole = datetime.fromisoformat(f"{day}T{clock}").replace(tzinfo=UTC)
    seconds = int(whole.timestamp())
    if found["zone"] not in (None, "Z"):
        zone = found["zone"].replace(":", "")
        seconds -= int(f"{zone[0]}1") * (int(zone[1:3]) * 3600 + int(zone[3:5]) * 60)
    return seconds * 10**9 + int((found["part"] or "0").ljust(9, "0"))
