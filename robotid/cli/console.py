"""Where a person and a script read: results on stdout, talk on stderr."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from io import StringIO
from math import isfinite
from typing import IO, TYPE_CHECKING, Literal

from robotid.errors import printable
from robotid.report.tables.table import Json, Table, for_people

if TYPE_CHECKING:
    from rich.console import Console

WIDE = 1000  # a table in a file or a pipe is never folded
TEXT = 24  # characters to which a column of sentences may shrink
GAP = 3  # between columns


def print_message(text: str, *, quiet: bool = False) -> None:
    """One line of talk."""
    if not quiet:
        print(printable(text, keep="\n"), file=sys.stderr, flush=True)


def print_json(document: Json) -> None:
    """One JSON document; a number that is not finite becomes null."""
    text = json.dumps(_finite(document), indent=2, ensure_ascii=False, allow_nan=False)
    if not _can_encode(text):
        text = json.dumps(_finite(document), indent=2, allow_nan=False)
    print(text)


def _can_encode(text: str) -> bool:
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except UnicodeEncodeError:
        return False
    return True


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
    on_terminal, buffer = sys.stdout.isatty(), StringIO()
    console = terminal(sys.stdout) if on_terminal else terminal(buffer, WIDE)
    parts = [part for table in tables for part in _parts(_printable(for_people(table)), console.width)]
    for i, table in enumerate(parts):
        if i:
            console.print()
        _print(table, console)
    if not on_terminal:
        print("\n".join(line.rstrip() for line in buffer.getvalue().splitlines()))


def _printable(table: Table) -> Table:
    """A table that steers no terminal, whatever names it shows."""
    return replace(
        table,
        title=printable(table.title),
        columns=tuple(map(printable, table.columns)),
        rows=tuple(tuple(map(printable, row)) for row in table.rows),
        note=printable(table.note, keep="\n"),
    )


def terminal(stream: IO[str], width: int | None = None) -> Console:
    """A console on a stream, without colours where NO_COLOR is set."""
    from rich.console import Console

    colours: Literal["auto"] | None = None if os.environ.get("NO_COLOR") else "auto"
    return Console(file=stream, highlight=False, width=width, color_system=colours)


def _parts(table: Table, width: int) -> Iterator[Table]:
    """A table without its empty columns, and where it is too wide as several, each with the first column."""
    filled = [i for i in range(len(table.columns)) if not i or not table.rows or any(row[i] for row in table.rows)]
    first, chosen = True, filled[:1]
    for i in filled[1:]:
        if len(chosen) > 1 and sum(_least(table, k) + GAP for k in (*chosen, i)) - GAP > width:
            yield _part(table, chosen, title=first, note=False)
            first, chosen = False, filled[:1]
        chosen.append(i)
    yield _part(table, chosen, title=first, note=True)


def _part(table: Table, columns: Sequence[int], *, title: bool, note: bool) -> Table:
    heads, *rows = (tuple(row[i] for i in columns) for row in (table.columns, *table.rows))
    return replace(
        table,
        title=table.title if title else "",
        columns=heads,
        rows=tuple(rows),
        note=table.note if note else "",
    )


def _least(table: Table, i: int) -> int:
    """Characters that a column needs: heads and sentences may be folded between words, names and numbers may not."""
    sentences = any(len(row[i].split()) > 3 for row in table.rows)
    cells = _widest(row[i] for row in table.rows)
    word = _widest(word for row in ((table.columns[i],), *((row[i],) for row in table.rows)) for word in row[0].split())
    return max(word, min(cells, TEXT)) if sentences else max(cells, _widest(table.columns[i].split()))


def _widest(texts: Iterable[str]) -> int:
    return max((len(line) for text in texts for line in text.splitlines()), default=0)


def _widths(table: Table, width: int) -> list[int]:
    """Characters for each column: what it needs, and of what is left over what it would like, narrow ones first."""
    heads = range(len(table.columns))
    found = [_least(table, i) for i in heads]
    liked = [max(_widest(row[i] for row in table.rows), len(table.columns[i])) for i in heads]
    spare = width - sum(found) - GAP * (len(found) - 1)
    for i in sorted(heads, key=lambda i: liked[i]):
        more = max(0, min(liked[i] - found[i], spare))
        found[i], spare = found[i] + more, spare - more
    return found


def _print(table: Table, console: Console) -> None:
    from rich import box
    from rich.table import Table as Grid
    from rich.text import Text

    grid = Grid(
        box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_header=any(table.columns), header_style="bold"
    )
    for i, (column, width) in enumerate(zip(table.columns, _widths(table, console.width), strict=True)):
        numeric = bool(table.rows) and all(_is_number(row[i]) for row in table.rows)
        grid.add_column(Text(column), justify="right" if numeric else "left", width=width)
    for row in table.rows:
        grid.add_row(*(Text(cell, table.styles.get(cell, "")) for cell in row))
    if table.title:
        console.print(Text(table.title, style="bold cyan"))
    console.print(grid)
    if table.note:
        console.print(Text(table.note, style="dim"))


def _is_number(text: str) -> bool:
    """Whether a cell is a number, a dash for none, or nothing."""
    try:
        float(text.rstrip("%"))
    except ValueError:
        return text in ("", "-")
    return True
