"""Tables as plain text and as HTML, for results that show themselves in Python."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from robotid.report.tables.table import Table, for_people

GAP = "   "  # between columns
RULE = "─"


def as_text(tables: Sequence[Table]) -> str:
    """Tables one below the other, each under its title, numbers flush right."""
    return "\n\n".join(map(_text, map(for_people, tables)))


def as_html(tables: Sequence[Table]) -> str:
    """Tables as HTML elements, without a page around them."""
    return "\n".join(map(_html, map(for_people, tables)))


def without_empty_columns(table: Table) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[bool]]:
    """Heads and rows of the columns that hold anything, and whether each holds numbers alone."""
    kept = [i for i in range(len(table.columns)) if not i or not table.rows or any(row[i] for row in table.rows)]
    rows = [tuple(row[i] for i in kept) for row in table.rows]
    numeric = [bool(rows) and all(is_number(row[i]) for row in rows) for i in range(len(kept))]
    return tuple(table.columns[i] for i in kept), rows, numeric


def is_number(text: str) -> bool:
    """Whether a cell is a number, a dash for none, or nothing."""
    try:
        float(text.strip().rstrip("%*"))
    except ValueError:
        return text.strip() in ("", "-")
    return True


def _text(table: Table) -> str:
    heads, rows, numeric = without_empty_columns(table)
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    body = [_line(row, widths, numeric) for row in rows]
    head = [_line(heads, widths, numeric), GAP.join(RULE * w for w in widths)] if any(heads) else []
    return "\n".join([*([table.title] if table.title else []), *head, *body, *table.note.splitlines()])


def _line(cells: Sequence[str], widths: Sequence[int], numeric: Sequence[bool]) -> str:
    set_ = (c.rjust(w) if right else c.ljust(w) for c, w, right in zip(cells, widths, numeric, strict=True))
    return GAP.join(set_).rstrip()


def _html(table: Table) -> str:
    heads, rows, numeric = without_empty_columns(table)
    style = [' style="text-align: right"' if right else ' style="text-align: left"' for right in numeric]
    head = "".join(f"<th{s}>{escape(cell)}</th>" for cell, s in zip(heads, style, strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td{s}>{escape(cell)}</td>" for cell, s in zip(row, style, strict=True)) + "</tr>"
        for row in rows
    )
    title = f'<caption style="text-align: left"><b>{escape(table.title)}</b></caption>' if table.title else ""
    note = f"<p>{'<br>'.join(map(escape, table.note.splitlines()))}</p>" if table.note else ""
    return f"<table>{title}{f'<thead><tr>{head}</tr></thead>' if any(heads) else ''}<tbody>{body}</tbody></table>{note}"
