"""What the environments came to, as a table for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum


class State(StrEnum):
    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class Outcome:
    """One environment. seconds : [s] by configuration; reason : why it failed or was skipped, in one line."""

    python: str
    side: str
    versions: dict[str, str] = field(default_factory=dict)
    reused: bool = False
    state: State = State.FAILED
    seconds: dict[str, float] = field(default_factory=dict)
    reason: str = ""

    def ended(self, state: State, reason: str = "", seconds: dict[str, float] | None = None) -> Outcome:
        """The same environment with its end."""
        return replace(self, state=state, reason=reason, seconds=seconds or {})


def table(outcomes: Sequence[Outcome]) -> str:
    """A row for each environment, what went wrong below, and the count of passes and failures in the last line."""
    packages = list(dict.fromkeys(name for one in outcomes for name in one.versions))
    runs = list(dict.fromkeys(name for one in outcomes for name in one.seconds))
    head = ["Python", "versions", *packages, *(f"{name} [s]" for name in runs), "environment", "outcome"]
    rows = [
        [
            one.python,
            one.side,
            *(one.versions.get(name, "") for name in packages),
            *(f"{one.seconds[name]:.1f}" if name in one.seconds else "" for name in runs),
            "kept" if one.reused else "new",
            str(one.state),
        ]
        for one in outcomes
    ]
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in (head, *rows)]
    reasons = [f"{one.python} {one.side}: {one.state}: {one.reason}" for one in outcomes if one.reason]
    counts = Counter(one.state for one in outcomes)
    total = [f"{counts[State.PASSED]} passed", f"{counts[State.FAILED]} failed"]
    if counts[State.SKIPPED]:
        total.append(f"{counts[State.SKIPPED]} skipped")
    return "\n".join([*(line.rstrip() for line in lines), *reasons, ", ".join(total)])
