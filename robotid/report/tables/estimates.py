"""Estimated parameters in JSON, and a change as a share of what it changes."""

from __future__ import annotations

from collections.abc import Iterable

from robotid.estimate.result import Estimate
from robotid.report.tables.table import Json


def estimates_document(estimates: Iterable[Estimate], prefix: str = "") -> dict[str, Json]:
    """Values by name, or by symbol where all begin with a prefix."""
    return {p.name.removeprefix(prefix): estimate_document(p) for p in estimates}


def estimate_document(p: Estimate) -> dict[str, Json]:
    """A value with its standard deviations."""
    return {"value": p.value, "std": p.std, "std_robust": p.std_robust, "unit": p.unit}


def relative(change: float, before: float) -> str:
    """A change in percent of what was there, empty where that is nothing."""
    return f"{100 * change / abs(before):+.3g}" if before else ""
