"""Results as rows of text, and the numbers in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite

Json = None | bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"]


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text under a title; columns that hold numbers are set flush right.

    styles : how a terminal shows cells of certain words, such as {"stale": "yellow"}.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    styles: Mapping[str, str] = field(default_factory=dict)


def number(value: float | None, digits: int = 4) -> str:
    """A number with so many significant digits; a dash where there is none."""
    return "-" if value is None or not isfinite(value) else f"{value:.{digits}g}"


def fixed(value: float | None, decimals: int = 2) -> str:
    """A number with so many decimals; a dash where there is none."""
    if value is None or not isfinite(value):
        return "-"
    return f"{round(value, decimals) + 0.0:.{decimals}f}"  # + 0.0 takes the sign from zero
