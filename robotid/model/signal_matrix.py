"""Small matrices at many samples, entry by entry: what is zero or the same everywhere costs next to nothing.

A matrix is a list of rows, a row a mapping from columns to entries: signals (n,), or plain numbers where the entry is
the same at every sample. What is not there is zero. Of a joint's derivatives most entries are of the last two kinds.
"""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.array import Array
from robotid.model.derivatives import Parts, accumulate

Rows = list[Parts]
"""The rows of a matrix."""


def multiply(a: Sequence[Parts], b: Sequence[Parts]) -> Rows:
    """The matrix product."""
    found: Rows = []
    for row in a:
        total: Parts = {}
        for j, factor in row.items():
            accumulate(total, factor, b[j])
        found.append(total)
    return found


def add(total: Rows, more: Sequence[Parts], factor: Array | float = 1.0) -> None:
    """Add a multiple of another matrix in place."""
    for row, other in zip(total, more, strict=True):
        accumulate(row, factor, other)


def scale(factor: Array | float, a: Sequence[Parts]) -> Rows:
    """A multiple of a matrix."""
    return [{k: factor * value for k, value in row.items()} for row in a]


def at(a: Sequence[Parts], samples: slice) -> Rows:
    """The matrix at some of its samples; signals of one sample stand for all."""
    return [{k: _part(value, samples) for k, value in row.items()} for row in a]


def put(a: Sequence[Parts], out: Array) -> Array:
    """The matrix as an array, written to out (rows, columns, n)."""
    for row, dense in zip(a, out, strict=True):
        for k, entry in enumerate(dense):
            entry[...] = row.get(k, 0.0)
    return out


def of_numbers(matrix: Array) -> Rows:
    """A matrix (rows, columns) that is the same at every sample."""
    return [{k: value for k, value in enumerate(row) if value != 0.0} for row in matrix.tolist()]


def of_signals(matrix: Array) -> Rows:
    """A matrix (rows, columns, n) that changes."""
    return [dict(enumerate(row)) for row in matrix]


def _part(entry: Array | float, samples: slice) -> Array | float:
    return entry if isinstance(entry, float) or len(entry) == 1 else entry[samples]
