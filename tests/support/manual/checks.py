"""The checks of the records, as they describe themselves."""

from __future__ import annotations

import inspect

from robotid.signals.plausibility import CHECKS
from robotid.signals.plausibility.check import Check

SEVERITIES = ("fatal", "warning", "note")


def checks() -> str:
    """A table of every check, by name, with how grave its findings can be."""
    found = (CHECKS[name] for name in sorted(CHECKS))
    rows = (f"| `{one.name}` | {_summary(one)} | {', '.join(severities(one))} |" for one in found)
    return "\n".join(("| check | what it finds | severity |", "| --- | --- | --- |", *rows))


def _summary(check: Check) -> str:
    return f"{check.summary[0].lower()}{check.summary[1:-1]}"


def severities(check: Check) -> list[str]:
    """How grave a check's findings can be, the gravest first."""
    source = inspect.getsource(check.examine)
    return [word for word in SEVERITIES if f'"{word}"' in source]
