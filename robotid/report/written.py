"""What writing a report comes to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Report:
    """What was written. shows : stages; left_out : artifacts that are stale, and why; figures : files."""

    file: Path
    summary: str
    shows: tuple[str, ...]
    left_out: dict[str, str]
    figures: tuple[Path, ...]
