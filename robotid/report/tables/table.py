"""Results as rows of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

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
