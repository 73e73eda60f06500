"""How the report writes numbers."""

from __future__ import annotations

from math import isfinite

NONE = "–"


def significant(value: float, digits: int = 3) -> str:
    """So many significant digits, powers of ten only where they spare zeros."""
    return f"{value:.{digits}g}" if isfinite(value) else NONE


def fixed(value: float, decimals: int = 2) -> str:
    """So many decimals, zero without a sign."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}" if isfinite(value) else NONE


def listed(words: list[str], last: str = "and") -> str:
    """Words as a sentence lists them."""
    return f" {last} ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
