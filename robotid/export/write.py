"""Files for other programs: MATLAB, JSON and CSV, each whole or absent."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from robotid.errors import ConfigError
from robotid.files import atomic_write
from robotid.model.array import Array

FORMATS = (".mat", ".json", ".csv")

Tree = Mapping[str, Any]
"""Names to numbers, texts, arrays, sequences of texts, and further trees."""

Columns = Mapping[str, Array | Sequence[str]]
"""Heads, with units, to values, (n,) each."""


def check_format(path: Path, further: Iterable[str] = ()) -> None:
    """Raises ConfigError for a format that nothing is written in. further : endings besides those of this module."""
    known = (*FORMATS, *further)
    if path.suffix.lower() not in known:
        close = get_close_matches(path.suffix.lower(), known, 1, 0.7)
        hint = f"did you mean {close[0]}?" if close else f"use {', '.join(known)}"
        raise ConfigError(f'nothing is exported as "{path.suffix}"', where=str(path), hint=hint)


def write_tree(path: Path, tree: Tree) -> None:
    """A tree as MATLAB structs or as JSON. Raises InputError where the file cannot be written."""
    atomic_write(path, _matlab(tree) if path.suffix.lower() == ".mat" else _json(tree))


def write_columns(path: Path, columns: Columns) -> None:
    """Columns as CSV, numbers as short as they are exact. Raises InputError where the file cannot be written."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    plain = (values.tolist() if isinstance(values, np.ndarray) else values for values in columns.values())
    writer.writerows(zip(*plain, strict=True))
    atomic_write(path, text.getvalue().encode())


def _matlab(tree: Tree) -> bytes:
    image = BytesIO()
    file: Any = image  # the stubs of SciPy 1.17 know names of files only
    savemat(file, _structs(tree), long_field_names=True, oned_as="column")
    return image.getvalue()


def _structs(tree: Tree) -> dict[str, Any]:
    """The tree as MATLAB takes it: names that it allows, texts in a sequence as a cell array."""
    found: dict[str, Any] = {}
    for name, value in tree.items():
        allowed = re.sub(r"\W", "_", name)
        allowed = allowed if allowed[0].isalpha() else f"x{allowed}"
        if isinstance(value, Mapping):
            found[allowed] = _structs(value)
        elif isinstance(value, Sequence) and not isinstance(value, str):
            found[allowed] = np.array(value, dtype=object).reshape(-1, 1)
        else:
            found[allowed] = math.nan if value is None else value
    return found


def _json(tree: Tree) -> bytes:
    return (json.dumps(_plain(tree), indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _plain(value: Any) -> Any:
    """Arrays as lists, numbers that are not finite as null."""
    if isinstance(value, Mapping):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
