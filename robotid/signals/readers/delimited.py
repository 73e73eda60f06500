"""Text tables: comma, semicolon, tab, bar or blanks between columns, decimal point or comma, one line of names.

Lines before the names, comments (#), a line of units below the names and empty cells are understood. Columns without
names are called by their positions, counted from 0. Dates are seconds from the first, as the file writes them.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robotid.errors import InputError, printable
from robotid.model.array import Array, Index
from robotid.signals.readers.dates import DATE, MISSING, seconds_of
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import Table
from robotid.signals.units import parse

SUFFIXES = (".csv", ".tsv", ".txt")

UNIT = re.compile(r"^(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\)|/\s+(\S+))$")
IN_MEMORY = 8  # times a text's own size that its lines and numbers take
BLANKS = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?(?:\s+[+-]?\d+(?:,\d+)?(?:[eE][+-]?\d+)?)+\s*$")
"""Numbers with decimal commas and blanks between them."""
GROUPED = re.compile(r"[+-]?\d{1,3}(?:(?:,\d{3})+\.\d+|(?:\.\d{3})+,\d+)")
"""A number with marks between its thousands and another one before its decimals. 1,000 alone has two meanings."""
HEXADECIMAL = re.compile(r"0[xX][0-9a-fA-F]+")
HEAD_LINES = 60  # lines from which the layout is guessed
CHUNK = 16_000_000  # characters of a text that are in memory as lines at once


@dataclass(frozen=True, slots=True)
class Layout:
    """How a file is written.

    delimiter : None for blanks; comma : it is the decimal mark; names, units : of the columns; first : line of numbers,
    counted from 0.
    """

    delimiter: str | None
    comma: bool
    names: tuple[str, ...]
    units: tuple[str, ...]
    first: int

    def number(self, cell: str) -> float | None:
        """What a cell says, nan where it is empty, None where it is no number."""
        if GROUPED.fullmatch(cell) and (_decimal_mark(cell) == ",") is self.comma:
            whole, _, part = cell.rpartition(_decimal_mark(cell))
            return _number(re.sub(r"[.,]", "", whole) + "." + part)
        return _number(cell.replace(",", ".") if self.comma else cell)


def read(path: Path) -> Table:
    """Columns by name. A unit in brackets, phi [deg], is taken off the name and kept.

    Raises InputError with the line of the first cell that is no number, or row that is too short or too long.
    """
    return parsed(path, text(path))


def parsed(path: Path, content: str) -> Table:
    """The same of the text of a file."""
    if "\r" in content:
        content = content.replace("\r\n", "\n").replace("\r", "\n")
    layout = _layout(path, next(_chunks(content)))
    content, unfinished = _finished(content, layout)
    found = _fast(content, layout)
    if found is not None:
        return replace(_table(path, layout, *found, {}), remarks=unfinished)
    lines = content.split("\n")
    rows = [k for k in range(layout.first, len(lines)) if _content(lines[k])]
    cells = _cells(path, lines, rows, layout)
    rows = [k for k, row in zip(rows, cells, strict=True) if any(row)]
    cells = [row for row in cells if any(row)]
    words = {
        j: cells[0][j] for j in range(len(layout.names)) if _is_text([row[j] for row in cells[:HEAD_LINES]], layout)
    }
    dates = [j for j, cell in words.items() if DATE.match(cell)]
    words = {j: cell for j, cell in words.items() if j not in dates}
    values = _slow(path, cells, rows, layout, dict.fromkeys((*words, *dates), ""))
    table = _table(path, layout, values, np.array(rows), words)
    times = [(printable(layout.names[j] or "time"), *seconds_of(path, [row[j] for row in cells], rows)) for j in dates]
    # with their origin before them, for the same times of another day are others
    dated = _once(path, [(name, np.concatenate([[zero], values])) for name, zero, values in times])
    seconds = {name: one[1:] for name, one in dated.items()}
    origins = {name: float(one[0]) for name, one in dated.items()}
    units = table.units | dict.fromkeys(seconds, "s")
    return replace(table.with_columns(seconds), units=units, origins=origins, remarks=unfinished)


def _finished(text: str, layout: Layout) -> tuple[str, tuple[str, ...]]:
    """A text without a last line that was not written to its end, as of a recorder that was switched off, and what was
    left out. Such a line has no end, and fewer columns than the names."""
    before, _, last = text.rpartition("\n")
    cells = _split(last, layout.delimiter)
    if not before or not _content(last) or len(cells) >= len(layout.names) or not _is_row(cells, layout.delimiter):
        return text, ()
    return before, (f"the last line breaks off after {len(cells)} of {len(layout.names)} columns, and is left out",)


def text(path: Path) -> str:
    """UTF-8, UTF-16 where it says so, else what Windows writes."""
    require_room(path, "it", IN_MEMORY * path.stat().st_size)
    raw = path.read_bytes()
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", errors="replace")
    if b"\0" in raw:
        raise InputError("this is not text", where=str(path), hint="save it as CSV, or name it after its format")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")


def _content(line: str) -> bool:
    return bool(line) and not line.isspace() and not line.lstrip().startswith("#")


def _layout(path: Path, lines: Sequence[str]) -> Layout:
    content = [k for k, line in enumerate(lines[:1000]) if _content(line) and not re.match('"?sep=', line)][:HEAD_LINES]
    if not content:
        raise InputError("the file is empty", where=str(path), hint="record again, or name another file")
    delimiter = _delimiter([lines[k] for k in content[len(content) // 2 :]])
    split = {k: _split(lines[k], delimiter) for k in content}
    width = Counter(len(_trimmed(split[k])) for k in content[-HEAD_LINES // 2 :]).most_common(1)[0][0]
    first = next((k for k in content if len(_trimmed(split[k])) == width and _is_row(split[k], delimiter)), None)
    if first is None:
        hexadecimal = next((cell for k in content for cell in split[k] if HEXADECIMAL.fullmatch(cell)), None)
        if hexadecimal is not None:
            what = f'the samples are hexadecimal, "{hexadecimal}", which does not tell their sign'
            raise InputError(what, where=str(path), hint="export decimal numbers")
        raise InputError("there are names but no samples", where=str(path), hint="record again, or name another file")
    names, units = _head(path, lines, [split[k] for k in content if k < first], first, width, delimiter)
    comma = delimiter != "," and _has_decimal_commas([cell for k in content if k >= first for cell in split[k]])
    return Layout(delimiter, comma, tuple(names), tuple(units), first)


def _delimiter(lines: Sequence[str]) -> str | None:
    if 2 * sum(BLANKS.match(line) is not None for line in lines) >= len(lines):
        return "\t" if all("\t" in line for line in lines) else None
    return next((d for d in (";", "\t", "|", ",") if 2 * sum(d in line for line in lines) >= len(lines)), None)


def _split(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return line.split()
    cells = next(csv.reader([line], delimiter=delimiter), []) if '"' in line else line.split(delimiter)
    return [cell.strip() for cell in cells]


def _trimmed(cells: list[str]) -> list[str]:
    """Without what follows the last delimiter, when that is nothing."""
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _is_row(cells: Sequence[str], delimiter: str | None) -> bool:
    numbers = sum(_is_number(cell, delimiter) or DATE.match(cell) is not None for cell in cells if cell)
    return numbers > 0 and 2 * numbers >= sum(bool(cell) for cell in cells)


def _decimal_mark(grouped: str) -> str:
    return max(".,", key=grouped.rfind)


def _has_decimal_commas(cells: Sequence[str]) -> bool:
    """Whether the comma stands before decimals, as one that is not between thousands does."""
    grouped = [cell for cell in cells if GROUPED.fullmatch(cell)]
    plain = [cell for cell in cells if not GROUPED.fullmatch(cell)]
    commas = any(_decimal_mark(cell) == "," for cell in grouped) and not any("." in cell for cell in plain)
    return commas or any("," in cell for cell in plain)


def _is_number(cell: str, delimiter: str | None) -> bool:
    plain = cell.replace(",", ".") if delimiter != "," else cell
    return _number(plain) is not None or GROUPED.fullmatch(cell) is not None


def _number(cell: str) -> float | None:
    if cell.lower() in MISSING:
        return float("nan")
    try:
        return None if "_" in cell else float(cell)
    except ValueError:
        return None


def _head(
    path: Path, lines: Sequence[str], above: list[list[str]], first: int, width: int, delimiter: str | None
) -> tuple[list[str], list[str]]:
    """Names and units above the first row; names may also stand in a comment."""
    rows = [cells for cells in above if len(_trimmed(cells)) >= width]
    if _are_pairs(rows) and not _are_units(rows[-1]):
        what = "every line above the numbers has a key before each signal, which has a time column of its own"
        raise InputError(
            what, where=str(path), hint="export one time column, and one line with the names of all columns"
        )
    comment = next((line for line in reversed(lines[:first]) if line.lstrip().startswith("#")), "")
    if not rows and len(_split(comment, delimiter)) >= width:
        rows = [_split(comment.lstrip().removeprefix("#").strip(), delimiter)]
    rows = rows or [cells for cells in above[-1:] if len(cells) > 1]
    if not rows:
        return [str(k) for k in range(width)], [""] * width
    units = rows[-1]
    if len(rows) > 1 and _are_units(units):
        return _named(rows[-2], [cell.strip("[]()") for cell in units])
    return _named(rows[-1], [""] * len(units))


def _are_units(cells: Sequence[str]) -> bool:
    return all(parse(cell.strip("[]()")) or cell in ("", "-") for cell in cells)


def _are_pairs(above: Sequence[list[str]]) -> bool:
    """Whether the same key stands before every value in all lines, as an oscilloscope writes its channels."""
    rows = [_trimmed(cells) for cells in above]
    return len(rows) > 1 and all(len(cells) > 3 and cells[0] and len({*cells[::2]}) == 1 for cells in rows)


def without_unit(name: str) -> tuple[str, str]:
    """A name without the unit that it carries in brackets or after a slash, and that unit, empty where there is none:
    "angle [deg]" is "angle", "deg"."""
    match = UNIT.match(name)
    unit = next((g for g in match.groups()[1:] if g), "") if match else ""
    return (match[1], unit) if match and match[1] and (match[2] or parse(unit)) else (name, "")


def _named(names: Sequence[str], units: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names without the units that they carry. A name that would come twice without its unit keeps it."""
    names = _trimmed(list(names))
    plain, carried = zip(*map(without_unit, names), strict=True) if names else ((), ())
    count = Counter(plain)
    kept = [name if count[short] > 1 else short for name, short in zip(names, plain, strict=True)]
    below = [*units, *[""] * (len(names) - len(units))]
    found = [unit or own for unit, own in zip(carried, below, strict=False)]
    return kept, found


def _chunks(text: str) -> Iterator[list[str]]:
    """All lines of a text, some millions of characters at a time."""
    begin = 0
    while begin <= len(text):
        end = text.find("\n", begin + CHUNK)
        end = len(text) if end < 0 else end
        yield text[begin:end].split("\n")
        begin = end + 1


def _fast(text: str, layout: Layout) -> tuple[Array, Index] | None:
    """All rows by numpy's parser with the numbers of their lines, or None where a cell is not a plain number."""
    parts, numbers, before = [], [], 0
    for lines in _chunks(text):
        rows = [k for k in range(max(0, layout.first - before), len(lines)) if _content(lines[k])]
        body = [lines[k].replace(",", ".") if layout.comma else lines[k] for k in rows]
        if rows:
            try:
                values = np.loadtxt(body, delimiter=layout.delimiter, ndmin=2, quotechar='"')
            except ValueError:
                return None
            if values.shape != (len(rows), len(layout.names)):
                return None
            parts.append(values)
            numbers.append(before + np.array(rows))
        before += len(lines)
    return (np.concatenate(parts), np.concatenate(numbers)) if parts else None


def _cells(path: Path, lines: Sequence[str], rows: list[int], layout: Layout) -> list[list[str]]:
    """Cells of every row, all as many as there are names. Raises InputError for a row of another length."""
    width = len(layout.names)
    cells = [_split(lines[k].split("#")[0], layout.delimiter) for k in rows]
    for k, found in zip(rows, cells, strict=True):
        if len(found) < width or any(found[width:]):
            what = f"{len(_trimmed(found))} columns where the names promise {width}"
            comma = len(found) == 2 * width and layout.delimiter == ","
            hint = "put ; between the columns if , is the decimal mark" if comma else "correct or remove the line"
            raise InputError(what, where=f"{path}:{k + 1}", hint=hint)
    return cells


def _is_text(cells: Sequence[str], layout: Layout) -> bool:
    """Whether a column holds words: most of its first cells are no numbers."""
    return 2 * sum(layout.number(cell) is None for cell in cells) > len(cells)


def _slow(path: Path, cells: list[list[str]], rows: list[int], layout: Layout, text: dict[int, str]) -> Array:
    """All rows cell by cell, (rows, names); nan in columns of text. Raises InputError for a cell that is no number."""
    values = np.full((len(cells), len(layout.names)), np.nan)
    numbers = [j for j in range(len(layout.names)) if j not in text]
    for i, row in enumerate(cells):
        for j in numbers:
            number = layout.number(row[j])
            if number is None:
                what = f'"{row[j]}" is not a number'
                raise InputError(what, where=f"{path}:{rows[i] + 1}", hint="correct or remove the line")
            values[i, j] = number
    return values


def _table(path: Path, layout: Layout, values: Array, rows: Index, text: dict[int, str]) -> Table:
    numbers = {j: name for j, name in enumerate(layout.names) if name and j not in text}
    if not numbers:
        raise InputError("no column holds numbers", where=str(path), hint="record again, or name another file")
    return Table(
        str(path),
        _once(path, [(printable(name), np.ascontiguousarray(values[:, j])) for j, name in numbers.items()]),
        {printable(name): layout.units[j] for j, name in numbers.items() if layout.units[j]},
        rows.astype(np.float64) + 1,
        {layout.names[j]: cell for j, cell in text.items()},
        order=tuple(printable(name or "time") for name in layout.names),
    )


def _once(path: Path, columns: Sequence[tuple[str, Array]]) -> dict[str, Array]:
    """Columns by name. The same samples may stand there twice, as the times that a drive writes before every signal.
    Raises InputError for others of the same name."""
    found: dict[str, Array] = {}
    for name, values in columns:
        if not np.array_equal(found.setdefault(name, values), values, equal_nan=True):
            hint = "rename one; of several time columns, export one"
            raise InputError(f'two columns are called "{name}", and differ', where=str(path), hint=hint)
    return found
