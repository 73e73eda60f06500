"""What a view says of an axis that slides: metres and newtons where views say radians and newton metres."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TypeVar

from robotid.cli.console import Table
from robotid.judge.diagnosis import Diagnosis, Extension
from robotid.model.units import sliding

T = TypeVar("T")
IN_BRACKETS = re.compile(r"\[([^\]]+)\]")
UNIT = "unit"  # heading of a column of units


def of_axis(content: T, *, linear: bool) -> T:
    """The content of a stage, its unit that of the axis."""
    if linear and isinstance(content, Diagnosis | Extension):
        return replace(content, unit=sliding(content.unit))
    return content


def slid(table: Table, *, linear: bool) -> Table:
    """A table with the units of the axis: in brackets, and those in a column of their own."""
    if not linear:
        return table
    units = [column == UNIT for column in table.columns]
    rows = tuple(
        tuple(sliding(cell) if unit else _bracketed(cell) for cell, unit in zip(row, units, strict=True))
        for row in table.rows
    )
    return replace(table, columns=tuple(map(_bracketed, table.columns)), rows=rows)


def _bracketed(text: str) -> str:
    return IN_BRACKETS.sub(lambda found: f"[{sliding(found[1])}]", text)
