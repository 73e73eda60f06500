"""What a page states about itself in its head: the digest of all that it shows, by which it is known to be up to date,
and its answer; and what writing it comes to."""

from __future__ import annotations

import re
from dataclasses import dataclass
from html import unescape
from pathlib import Path

STAMP = re.compile(r'<meta name="robotid-stamp" content="([0-9a-f]+)">\n<meta name="description" content="([^"]*)">')


@dataclass(frozen=True, slots=True)
class Stamp:
    """digest : of what a page shows. summary : its answer, a paragraph."""

    digest: str
    summary: str


def stamp_of(text: str) -> Stamp | None:
    """The stamp of a page, None of any other text."""
    found = STAMP.search(text)
    return Stamp(found[1], unescape(found[2])) if found else None


@dataclass(frozen=True, slots=True)
class Report:
    """What was written. shows : stages; left_out : artifacts that are stale, and why; figures : files; remarks : on
    them."""

    file: Path
    summary: str
    shows: tuple[str, ...]
    left_out: dict[str, str]
    figures: tuple[Path, ...]
    remarks: tuple[str, ...] = ()
