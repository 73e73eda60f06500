"""Units of a turning axis, and of a sliding one that the same equations describe."""

from __future__ import annotations

SLIDING = {"rad": "m", "Nm": "N", "kg": "kg", "m2": "", "rad2": "m2", "rad3": "m3", "s2/rad2": "s2/m2", "s/rad": "s/m"}
"""Words of a turning axis' units and what they become; others stay."""


def sliding(unit: str) -> str:
    """The unit of a turning axis as a sliding one has it: rad is m, Nm is N, kg m2 is kg."""
    words = [_word(word) for word in unit.split(" ")]
    return " ".join(word for word in words if word)


def _word(word: str) -> str:
    if word in SLIDING:
        return SLIDING[word]
    return "/".join(SLIDING.get(part, part) for part in word.split("/"))
