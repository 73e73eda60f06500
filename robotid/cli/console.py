"""Where a person and a script read: results on stdout, talk on stderr."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from math import isfinite
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console

Json = None | bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"]

WIDE = 1000  # a table in a file or a pipe is never folded


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text under a title; columns that hold numbers are set flush right."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def say(text: str, *, quiet: bool = False) -> None:
    """One line of talk."""
    if not quiet:
        print(text, file=sys.stderr, flush=True)


def print_json(document: Json) -> None:
    """One JSON document; a number that is not finite becomes null."""
    print(json.dumps(_finite(document), indent=2, ensure_ascii=False, allow_nan=False))


def _finite(document: Json) -> Json:
    if isinstance(document, float):
        return document if isfinite(document) else None
    if isinstance(document, Mapping):
        return {key: _finite(value) for key, value in document.items()}
    if isinstance(document, Sequence) and not isinstance(document, str):
        return [_finite(value) for value in document]
    return document


def print_tables(tables: Sequence[Table]) -> None:
    """Tables on stdout; where that is not a terminal, bare of colour and as wide as need be."""
    from rich.console import Console

    terminal = sys.stdout.isatty()
    stream = sys.stdout if terminal else StringIO()
    colours: Literal["auto"] | None = None if "NO_COLOR" in os.environ else "auto"
    console = Console(file=stream, highlight=False, width=None if terminal else WIDE, color_system=colours)
    for i, table in enumerate(tables):
        if i:
            console.print()
        _print(table, console)
    if isinstance(stream, StringIO):
        print("\n".join(line.rstrip() for line in stream.getvalue().splitlines()))


def _print(table: Table, console: Console) -> None:
    from rich import box
    from rich.table import Table as Grid
    from rich.text import Text

    grid = Grid(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_header=any(table.columns))
    for i, column in enumerate(table.columns):
        numeric = bool(table.rows) and all(_is_number(row[i]) for row in table.rows)
        grid.add_column(Text(column), justify="right" if numeric else "left")
    for row in table.rows:
        grid.add_row(*map(Text, row))
    if table.title:
        console.print(Text(table.title, style="bold"))
    console.print(grid)
    if table.note:
        console.print(Text(table.note))


def _is_number(text: str) -> bool:
    """Whether a cell is a number, a dash for none, or nothing."""
    try:
        float(text.rstrip("%"))
    except ValueError:
        return text in ("", "-")
    return True


def number(value: float | None, digits: int = 4) -> str:
    """A number with so many significant digits; a dash where there is none."""
    return "-" if value is None or not isfinite(value) else f"{value:.{digits}g}"


def fixed(value: float | None, decimals: int = 2) -> str:
    """A number with so many decimals; a dash where there is none."""
    if value is None or not isfinite(value):
        return "-"
    return f"{round(value, decimals) + 0.0:.{decimals}f}"  # + 0.0 takes the sign from zero
