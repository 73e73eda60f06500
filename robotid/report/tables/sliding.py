"""Tables of an axis that slides: metres and newtons where tables have radians and newton metres."""

from __future__ import annotations

import re
from dataclasses import replace

from robotid.model.units import sliding
from robotid.report.tables.table import Table

IN_BRACKETS = re.compile(r"\[([^\]]+)\]")
UNIT = "unit"  # heading of a column of units


def in_units_of_axis(table: Table, *, linear: bool) -> Table:
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
