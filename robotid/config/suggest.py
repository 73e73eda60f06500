"""Did you mean: the nearest of the words that would have been right."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher

NEAR = 0.6


def suggest(word: str, known: Iterable[str], *, many: int = 12) -> str:
    """A hint: the nearest known word, else all of them if they are not too many, else nothing."""
    words = list(known)
    near = nearest(word, words)
    if near is not None:
        return f"did you mean {near}?"
    return f"one of {', '.join(words)}" if 0 < len(words) <= many else ""


def nearest(word: str, known: Iterable[str]) -> str | None:
    """The known word most like this one, if any is. The parts of spring_cubik may stand in any order."""
    close = max(known, key=lambda k: _likeness(word, k), default=None)
    return close if close is not None and _likeness(word, close) >= NEAR else None


def _likeness(word: str, known: str) -> float:
    a, b = (w.lower().replace("-", "_") for w in (word, known))
    return max(SequenceMatcher(None, x, y).ratio() for x, y in ((a, b), (_sorted(a), _sorted(b))))


def _sorted(word: str) -> str:
    return "_".join(sorted(word.split("_")))
