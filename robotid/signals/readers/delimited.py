"""Text tables: comma, semicolon (decimal comma allowed), tab or blank between columns, one line of names."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table
from robotid.signals.units import is_known

SUFFIXES = (".csv", ".tsv", ".txt")

UNIT = re.compile(r"^(.*?)\s*[\[(]([^\])]*)[\])]\s*$")
MEND = "mend or remove the line"


@dataclass(frozen=True, slots=True)
class _Text:
    """Names, then numbers: the lines that are neither blank nor comment. lines : their numbers in the file."""

    path: Path
    rows: list[str]
    lines: list[int]
    delimiter: str | None

    def cells(self, k: int) -> list[str]:
        return [cell.strip().strip('"').strip() for cell in self.rows[k].split(self.delimiter)]

    def value(self, cell: str) -> float:
        """An empty cell is a missing sample; between semicolons a comma is a decimal one."""
        return float(cell.replace(",", ".") if self.delimiter == ";" else cell) if cell.strip() else np.nan

    def where(self, k: int) -> str:
        return f"{self.path}:{self.lines[k]}"


def read(path: Path) -> Table:
    """Columns by the names of the first line. A unit in brackets, phi [deg], is taken off the name and kept."""
    text = _text(path)
    if not text.rows:
        raise InputError("the file is empty", where=str(path), hint="record again, or name another file")
    names = text.cells(0)
    if _all_numbers(text):
        what = "the first line holds numbers, not names"
        raise InputError(what, where=text.where(0), hint="add a line of column names")
    if len(text.rows) == 1:
        raise InputError("there are names but no samples", where=str(path), hint="record again, or name another file")
    columns, units = _named(path, names, _numbers(text, len(names)))
    return Table(str(path), columns, units, np.array(text.lines[1:]))


def _text(path: Path) -> _Text:
    rows, lines, comment = [], [], ""
    try:
        with path.open(encoding="utf-8-sig") as file:
            for k, line in enumerate(file, start=1):
                row = line.partition("#")[0].rstrip("\n")
                if row.strip():
                    rows.append(row)
                    lines.append(k)
                elif not rows:
                    comment = line.lstrip("# ").rstrip("\n")
    except UnicodeDecodeError as error:
        raise InputError("this is not UTF-8 text", where=str(path), hint="save it as CSV in UTF-8") from error
    text = _Text(path, rows, lines, next((d for d in (";", "\t", ",") if rows and d in rows[0]), None))
    return _with_names_of(comment, text)


def _with_names_of(comment: str, text: _Text) -> _Text:
    """Names may stand in the comment before the first row, as NumPy writes them."""
    names = replace(text, rows=[comment, *text.rows], lines=[text.lines[0] - 1, *text.lines]) if text.rows else text
    if not text.rows or len(names.cells(0)) != len(text.cells(0)) or not _all_numbers(text):
        return text
    return names


def _all_numbers(text: _Text) -> bool:
    return all(_is_number(text, cell) for cell in text.cells(0))


def _numbers(text: _Text, width: int) -> Array:
    """The table, (n, width). Cell by cell only where a plain reading fails, for it is slow."""
    for converters in (None, text.value):
        try:
            values = np.loadtxt(
                text.rows[1:],
                delimiter=text.delimiter,
                comments=None,
                quotechar='"',
                ndmin=2,
                converters=converters,
                encoding=None,
            )
        except ValueError:
            continue
        if values.shape[1] == width:
            return np.asarray(values)
    raise _complaint(text, width)


def _complaint(text: _Text, width: int) -> InputError:
    """The first line that is not a row of numbers, in words."""
    for k in range(1, len(text.rows)):
        cells = text.cells(k)
        if len(cells) != width:
            return InputError(f"{len(cells)} columns where the names promise {width}", where=text.where(k), hint=MEND)
        for cell in cells:
            if not _is_number(text, cell):
                return InputError(f'"{cell}" is not a number', where=text.where(k), hint=MEND)
    return InputError("this is not a table of numbers", where=str(text.path), hint="save it as CSV")


def _is_number(text: _Text, cell: str) -> bool:
    try:
        text.value(cell)
    except ValueError:
        return False
    return True


def _named(path: Path, names: list[str], values: Array) -> tuple[dict[str, Array], dict[str, str]]:
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    for name, column in zip(names, values.T, strict=True):
        found = UNIT.match(name)
        unit = found[2].strip() if found else ""
        plain = found[1] if found and is_known(unit) else name
        if plain in columns:
            raise InputError(f'two columns are called "{plain}"', where=str(path), hint="rename one")
        columns[plain] = np.ascontiguousarray(column)
        if found and is_known(unit):
            units[plain] = unit
    return columns, units
