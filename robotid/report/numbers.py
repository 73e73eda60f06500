"""How the report writes numbers."""

from __future__ import annotations

from math import isfinite

NONE = "–"
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MOST_ZEROS = 5  # powers of ten up to here are written out


def significant(value: float, digits: int = 3) -> str:
    """So many significant digits, powers of ten only where they spare zeros."""
    if not isfinite(value):
        return NONE
    text = f"{value:.{digits}g}"
    mantissa, _, power = text.partition("e")
    if not power:
        return text
    return f"{float(text):.0f}" if 0 <= int(power) <= MOST_ZEROS else f"{mantissa}·{ten_to(int(power))}"


def ten_to(power: int) -> str:
    """A power of ten as people write it."""
    return f"10{str(power).translate(SUPERSCRIPT)}"


def fixed(value: float, decimals: int = 2) -> str:
    """So many decimals, zero without a sign."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}" if isfinite(value) else NONE


def listed(words: list[str], last: str = "and") -> str:
    """Words as a sentence lists them."""
    return f" {last} ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
