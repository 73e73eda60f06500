"""How numbers, times and lists are written for people: in tables, in sentences, on figures."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, isfinite, log10

LONG = 1e7  # from which decimals are not worth their place
NONE = "-"
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
ROUNDING = 1e-12  # [rad/s, rad, m/s, m] an error below it comes of rounding, and of nothing measured
LEAST_PROBABILITY = 1e-300  # the tail of a distribution underflows below it
MAX_DIGITS = 10  # of a value
MAX_ZEROS = 5  # powers of ten up to here are written out


def number(value: float | None, digits: int = 4) -> str:
    """A number with so many significant digits, as programs read it too: 220, 1.46e+06. A dash where there is none."""
    if value is None or not isfinite(value):
        return NONE
    text = f"{value + 0.0:.{digits}g}"  # + 0.0 takes the sign from zero
    _, _, power = text.partition("e")
    return f"{float(text):.0f}" if power and 0 < int(power) <= MAX_ZEROS else text


def probability(value: float | None) -> str:
    """A p-value, as programs read it too: never zero, which no test can tell from what is too small to be written."""
    return "<1e-300" if value is not None and value < LEAST_PROBABILITY else number(value, 2)


def resolved(value: float, std: float) -> str:
    """A value with so many digits that two of its standard deviation can be seen in it, four at least."""
    if not (isfinite(value) and isfinite(std) and value and std > 0):
        return number(value)
    return number(value, min(MAX_DIGITS, max(4, floor(log10(abs(value))) - floor(log10(std)) + 2)))


def fixed(value: float | None, decimals: int = 2) -> str:
    """A number with so many decimals, zero without a sign; a power of ten from ten millions on. A dash where there is
    none."""
    if value is None or not isfinite(value):
        return NONE
    if abs(value) >= LONG:
        return number(value)
    return f"{round(value, decimals) + 0.0:.{decimals}f}"  # + 0.0 takes the sign from zero


def significant(value: float | None, digits: int = 3) -> str:
    """A number with so many significant digits for a sentence, powers of ten only where they spare zeros: 1.46·10⁶."""
    mantissa, _, power = number(value, digits).partition("e")
    return f"{mantissa}·{ten_to(int(power))}" if power else mantissa


def plain(value: float | None, digits: int = 3) -> str:
    """A number with so many significant digits for a message that any terminal shows: 140, 1.46e6, 2e-9."""
    mantissa, _, power = number(value, digits).partition("e")
    return f"{mantissa}e{int(power)}" if power else mantissa


def rms(value: float | None, digits: int = 3) -> str:
    """The size of an error in SI units with so many significant digits, 0 where it is rounding."""
    return "0" if value is not None and abs(value) < ROUNDING else number(value, digits)


def ten_to(power: int) -> str:
    """A power of ten as people write it."""
    return f"10{str(power).translate(SUPERSCRIPT)}"


def percent(share: float | None, decimals: int = 1) -> str:
    """A share of one as a number of percent, without the sign: 97.2; <0.1 where it is small but not zero."""
    least = _unseen(share, decimals)
    return f"<{least}" if least else fixed(None if share is None else 100 * share, decimals)


def portion(share: float | None, decimals: int = 1) -> str:
    """A share of one in percent for a sentence: 97.2 %; below 0.1 % where it is small but not zero."""
    least = _unseen(share, decimals)
    return f"below {least} %" if least else f"{percent(share, decimals)} %"


def _unseen(share: float | None, decimals: int) -> str:
    """The smallest percentage that has a digit, where a share that is not zero would have none; else empty."""
    least = 10.0**-decimals
    return fixed(least, decimals) if share is not None and ROUNDING < share < 0.005 * least else ""


def duration(seconds: float) -> str:
    """A time as people state it: 8 s, 2 min 05 s, 1 h 10 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60} min {whole % 60:02d} s" if whole < 3600 else f"{whole // 3600} h {whole // 60 % 60:02d} min"


def listed(words: Sequence[str], last: str = "and") -> str:
    """Words as a sentence lists them."""
    return f" {last} ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def capitalised(sentence: str) -> str:
    """A sentence that begins with a capital, unless it begins with the name of a parameter."""
    return sentence if "." in sentence.partition(" ")[0] else f"{sentence[0].upper()}{sentence[1:]}"
