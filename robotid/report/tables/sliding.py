"""Tables of an axis that slides: metres, newtons and forces where tables have radians, newton metres and torques."""

from __future__ import annotations

import re
from dataclasses import replace

from robotid.model.units import sliding, sliding_words
from robotid.report.tables.table import UNIT, Table

IN_BRACKETS = re.compile(r"\[([^\]]+)\]")


def in_units_of_axis(table: Table, *, linear: bool) -> Table:
    """A table with the units of the axis, in brackets and in a column of their own, and with its words. A cell of one
    word is a name, and stays."""
    if not linear:
        return table
    units = [column == UNIT for column in table.columns]
    rows = tuple(
        tuple(sliding(cell) if unit else _cell(cell) for cell, unit in zip(row, units, strict=True))
        for row in table.rows
    )
    columns = tuple(map(_text, table.columns))
    return replace(table, title=_text(table.title), columns=columns, rows=rows, note=_text(table.note))


def in_words_of_axis(sentence: str, *, linear: bool) -> str:
    """A sentence with the words and units of the axis."""
    return _text(sentence) if linear else sentence


def _cell(text: str) -> str:
    return _text(text) if " " in text else text


def _text(text: str) -> str:
    return sliding_words(IN_BRACKETS.sub(lambda found: f"[{sliding(found[1])}]", text))
