"""JSON: an object a line, as loggers and message brokers write it, a list of such objects, or an object of lists.

Objects within objects become dotted names. Dates are seconds from the first.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from robotid.errors import InputError, printable
from robotid.model.array import Array
from robotid.signals.readers.dates import DATE, seconds_of
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import Table, floats

SUFFIXES = (".jsonl", ".ndjson", ".json")

IN_MEMORY = 20  # times a text's own size that its objects take
MAX_DEPTH = 16  # of objects in each other
LONGEST = 40  # characters of a text that a message shows


def read(path: Path) -> Table:
    """Every numeric column; a sample that an object leaves out is missing.

    Raises InputError where the text is no JSON, with the line, or holds no samples.
    """
    require_room(path, "it", IN_MEMORY * path.stat().st_size)
    rows = _rows(path, path.read_bytes())
    cells: dict[str, dict[int, Any]] = {}
    for k, row in enumerate(rows):
        for name, value in _flat(row):
            cells.setdefault(printable(name), {})[k] = value
    columns, units, origins, text = dict[str, Array](), dict[str, str](), dict[str, float](), dict[str, str]()
    for name, found in cells.items():
        words = [str(value) for value in found.values() if not isinstance(value, int | float | None)]
        if len(words) == len(rows) and DATE.match(words[0]):
            origins[name], columns[name] = seconds_of(path, words, list(range(len(rows))))
            units[name] = "s"
        elif words:
            text[name] = printable(words[0][:LONGEST])
        else:
            columns[name] = _column(path, name, found, len(rows))
    if not columns:
        raise InputError("no column holds numbers", where=str(path), hint="record again, or name another file")
    return Table(str(path), columns, units, None, text, origins=origins, order=tuple(cells))


def _rows(path: Path, raw: bytes) -> list[dict[str, Any]]:
    try:
        content = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("this is no text in UTF-8", where=str(path), hint="save it again") from error
    lines = [(k, line) for k, line in enumerate(content.split("\n"), 1) if line.strip()]
    one_a_line = len(lines) > 1 and all(line.strip()[0] == "{" and line.strip()[-1] == "}" for _, line in lines[:2])
    if one_a_line:
        found: Any = [_parsed(f"{path}:{k}", line) for k, line in lines]
    else:
        found = _parsed(str(path), content)
    if isinstance(found, dict):
        lists = {name: values for name, values in _flat(found) if isinstance(values, list)}
        lengths = {len(values) for values in lists.values()}
        if len(lengths) > 1:
            hint = "save signals of one clock, each in a list, or an object a sample"
            raise InputError("the lists are of different lengths", where=str(path), hint=hint)
        found = [dict(zip(lists, row, strict=True)) for row in zip(*lists.values(), strict=True)]
    if not isinstance(found, list) or not found or not all(isinstance(row, dict) for row in found):
        hint = "save an object a sample, one a line or in a list, or an object of lists"
        raise InputError("this JSON holds no samples", where=str(path), hint=hint)
    return found


def _parsed(where: str, text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("this is not readable as JSON", where=where, hint="save it again") from error


def _flat(row: dict[str, Any], above: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Dotted names and what stands there."""
    for key, value in row.items():
        if not isinstance(value, dict):
            yield above + key, value
        elif depth < MAX_DEPTH:
            yield from _flat(value, f"{above}{key}.", depth + 1)


def _column(path: Path, name: str, found: dict[int, Any], count: int) -> Array:
    """Samples (count,) by their rows; nan where there is none."""
    values = np.full(count, np.nan)
    known = {k: value for k, value in found.items() if value is not None}
    if len(known) == count and all(isinstance(value, int) and abs(value) < 2**63 for value in known.values()):
        return floats(np.array(list(known.values()), dtype=np.int64))
    try:
        values[list(known)] = [float(value) for value in known.values()]
    except OverflowError as error:
        what = f'"{name}" holds an integer that is larger than any number'
        raise InputError(what, where=str(path), hint="save numbers, or null for a missing one") from error
    return values
