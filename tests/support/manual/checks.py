"""The checks of the records, as they describe themselves."""

from __future__ import annotations

from robotid.signals.plausibility import CHECKS


def checks() -> str:
    """A table of every check, by name."""
    rows = (f"| `{name}` | {CHECKS[name].summary[0].lower()}{CHECKS[name].summary[1:-1]} |" for name in sorted(CHECKS))
    return "\n".join(("| check | what it finds |", "| --- | --- |", *rows))
