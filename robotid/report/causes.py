"""The ranking of causes: what each explains, and what was tried in vain."""

from __future__ import annotations

from math import isfinite

from matplotlib.axes import Axes

from robotid.judge.diagnosis import Cause, Diagnosis
from robotid.report.axes import BLUE, FAINT, INK, dress
from robotid.report.numbers import fixed

MOST_REJECTED = 8
THICK = 0.62
LEFT = "#B9B9B9"  # bars of what was rejected


def rows_of(diagnosis: Diagnosis) -> int:
    """How many bars there are to draw."""
    return len(diagnosis.causes) + min(MOST_REJECTED, len(diagnosis.rejected))


def draw_causes(axes: Axes, diagnosis: Diagnosis) -> None:
    """A bar an effect, causes first in their order, then the best of the rejected."""
    rejected = sorted(diagnosis.rejected, key=lambda r: -r.explained)[:MOST_REJECTED]
    for k, cause in enumerate(diagnosis.causes):
        _bar(axes, k, cause.effect, cause.explained, BLUE, _said(cause))
    for k, one in enumerate(rejected, start=len(diagnosis.causes)):
        _bar(axes, k, one.effect, one.explained, LEFT, "rejected")
    axes.invert_yaxis()
    axes.set_yticks([])
    axes.set_xlim(0, 100)
    dress(axes, "share of the misfit explained [%]", "", f"What {diagnosis.model} lacks")
    axes.grid(False, axis="y")
    axes.spines["left"].set_visible(False)


def _bar(axes: Axes, k: int, name: str, share: float, shade: str, said: str) -> None:
    axes.barh(k + 0.16, 100 * share, THICK * 0.6, color=shade)
    axes.text(0, k - 0.2, name, fontsize=8.5, va="center", color=INK)
    axes.text(100, k - 0.2, said, fontsize=8, va="center", ha="right", color=FAINT)


def _said(cause: Cause) -> str:
    others = [twin for twin in cause.twins if twin != cause.effect]
    gain = f"{cause.heldout_gain:+.2f} points held out" if isfinite(cause.heldout_gain) else ""
    share = f"{fixed(100 * cause.explained, 1)} %"
    return ", ".join(filter(None, (share, gain, f"or {', '.join(others)}" if others else "")))
