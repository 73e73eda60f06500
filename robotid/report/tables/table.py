"""Results as rows of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from robotid.model.units import typeset, typeset_unit

Json = None | bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"]


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text under a title; columns that hold numbers are set flush right.

    styles : how a terminal shows cells of certain words, such as {"stale": "yellow"}.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    styles: Mapping[str, str] = field(default_factory=dict)


UNIT = "unit"
"""Heading of a column of units."""


def for_people(table: Table) -> Table:
    """A table with its units as they are printed, powers raised. A cell of one word outside the column of units is a
    name, and stays."""
    units = [column == UNIT for column in table.columns]
    rows = tuple(
        tuple(typeset_unit(cell) if unit else _cell(cell) for cell, unit in zip(row, units, strict=True))
        for row in table.rows
    )
    columns = tuple(map(typeset, table.columns))
    return replace(table, title=typeset(table.title), columns=columns, rows=rows, note=typeset(table.note))


def _cell(text: str) -> str:
    return typeset(text) if " " in text else text
