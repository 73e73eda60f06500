"""What the trials on two axes come to, in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from study.axes.plan import KINDS
from study.axes.trial import Result

HEAD = ("hidden", "trials", "first", "first or its class", "false causes", "oracle's gain, median", "95 % of it")
WORDS = {
    "coupling": "coupling left out",
    "pose": "pose-dependent inertia left out",
    "friction": "a friction effect while the other axis moves",
    "temperature": "friction that follows the temperature",
    "clean": "nothing",
}


def table(results: Sequence[Result]) -> str:
    """A line for each kind of trial."""
    lines = [_row(HEAD), _row(["---"] * len(HEAD))]
    for kind in KINDS:
        own = [r for r in results if r.kind == kind]
        if own:
            lines.append(_row([WORDS[kind], str(len(own)), *_figures(own, told=kind != "clean")]))
    return "\n".join(lines)


def _figures(results: Sequence[Result], *, told: bool) -> list[str]:
    false = f"{sum(r.false for r in results)} in {sum(r.false > 0 for r in results)} trials"
    if not told:
        return ["-", "-", false, "-", "-"]
    shares = np.array([r.share for r in results])
    good = np.mean(shares >= 0.95)
    median = f"{100 * np.nanmedian(shares):.0f} %" if np.isfinite(shares).any() else "-"
    rates = [f"{100 * np.mean([getattr(r, name) for r in results]):.0f} %" for name in ("first", "in_class")]
    return [*rates, false, median, f"{100 * good:.0f} %"]


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
