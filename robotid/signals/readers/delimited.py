"""Text tables: comma, semicolon (decimal comma allowed), tab or blank between columns, one line of names."""

from __future__ import annotations

import re
from io import StringIO
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table
from robotid.signals.units import is_known

SUFFIXES = (".csv", ".tsv", ".txt")

UNIT = re.compile(r"^(.*?)\s*[\[(]([^\])]*)[\])]\s*$")


def read(path: Path) -> Table:
    """Columns by the names of the first line. A unit in brackets, phi [deg], is taken off the name and kept."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("this is not UTF-8 text", where=str(path), hint="save it as CSV in UTF-8") from error
    lines = text.splitlines()
    head = next((k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")), None)
    if head is None:
        raise InputError("the file is empty", where=str(path), hint="record again, or name another file")
    delimiter = _delimiter(lines[head])
    names = [cell.strip().strip('"') for cell in _cells(lines[head], delimiter)]
    if all(_is_number(name, delimiter) for name in names):
        raise InputError("the first line holds numbers, not names", where=f"{path}:{head + 1}", hint="add a line of column names")
    values = _numbers(path, lines, head + 1, delimiter, len(names))
    return _table(path, names, values, head + 2)


def _table(path: Path, names: list[str], values: Array, first_line: int) -> Table:
    columns, units = {}, {}
    for name, column in zip(names, values.T, strict=True):
        found = UNIT.match(name)
        plain = found[1] if found and is_known(found[2].strip()) else name
        if plain in columns:
            raise InputError(f'two columns are called "{plain}"', where=str(path), hint="rename one")
        columns[plain] = np.ascontiguousarray(column)
        if found and is_known(found[2].strip()):
            units[plain] = found[2].strip()
    return Table(str(path), columns, units, first_line)


def _delimiter(line: str) -> str | None:
    return next((d for d in (";", "\t", ",") if d in line), None)


def _cells(line: str, delimiter: str | None) -> list[str]:
    return line.split(delimiter)


def _is_number(cell: str, delimiter: str | None) -> bool:
    try:
        float(cell.replace(",", ".") if delimiter == ";" else cell)
    except ValueError:
        return False
    return True


def _numbers(path: Path, lines: list[str], first: int, delimiter: str | None, width: int) -> Array:
    body = "\n".join(lines[first:])
    if not body.strip():
        raise InputError("there are names but no samples", where=str(path), hint="record again, or name another file")
    if delimiter == ";":
        body = body.replace(",", ".")
    try:
        values = np.loadtxt(StringIO(_filled(body, delimiter)), delimiter=delimiter, ndmin=2)
    except ValueError:
        raise _complaint(path, lines, first, delimiter, width) from None
    if values.shape[1] != width:
        raise _complaint(path, lines, first, delimiter, width)
    return np.asarray(values)


def _filled(body: str, delimiter: str | None) -> str:
    """Empty cells are missing samples."""
    if delimiter is None:
        return body
    d = re.escape(delimiter)
    return re.sub(rf"(?m)(?:(?<={d})|^)[ \t]*(?={d}|$)(?!^\s*$)", "nan", body) if re.search(rf"(?m){d}\s*({d}|$)|^{d}", body) else body


def _complaint(path: Path, lines: list[str], first: int, delimiter: str | None, width: int) -> InputError:
    """The first line that is not a row of numbers, in words."""
    for k, line in enumerate(lines[first:], start=first + 1):
        if not line.strip() or line.startswith("#"):
            continue
        cells = _cells(line, delimiter)
        if len(cells) != width:
            what = f"{len(cells)} columns where the names promise {width}"
            return InputError(what, where=f"{path}:{k}", hint="mend or remove the line")
        for cell in cells:
            if cell.strip() and not _is_number(cell, delimiter):
                return InputError(f'"{cell.strip()}" is not a number', where=f"{path}:{k}", hint="mend or remove the line")
    return InputError("this is not a table of numbers", where=str(path), hint="save it as CSV")
