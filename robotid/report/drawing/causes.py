"""The ranking of causes: what each explains, and what was rejected."""

from __future__ import annotations

from math import isfinite

from matplotlib.axes import Axes

from robotid.diagnosis.results import Cause, Diagnosis
from robotid.numerals import portion
from robotid.report.style.axes import BLUE, FAINT, INK, QUIET, style_axes

MAX_REJECTED = 8
BAR_HEIGHT = 0.37
LABEL_ROOM = 62  # [%] for the labels, beside the bars


def rows_of(diagnosis: Diagnosis) -> int:
    """How many bars there are to draw."""
    return len(diagnosis.causes) + min(MAX_REJECTED, len(diagnosis.rejected))


def draw_causes(axes: Axes, diagnosis: Diagnosis, most_rejected: int = MAX_REJECTED) -> None:
    """A bar an effect, causes first in their order, then the best of the rejected; its share and gain at its end."""
    rejected = sorted(diagnosis.rejected, key=lambda r: -r.explained)[:most_rejected]
    for k, cause in enumerate(diagnosis.causes):
        _bar(axes, k, " or ".join((cause.effect, *_others(cause))), cause.explained, BLUE, _label(cause))
    for k, one in enumerate(rejected, start=len(diagnosis.causes)):
        _bar(axes, k, one.effect, one.explained, FAINT, "rejected")
    axes.set_ylim(len(diagnosis.causes) + len(rejected) - 0.5, -0.55)
    axes.set_yticks([])
    axes.set_xlim(0, 100 + LABEL_ROOM)
    axes.set_xticks(range(0, 101, 20))
    style_axes(axes, "share of the misfit explained [%]", "", f"What {diagnosis.model} lacks")
    axes.xaxis.label.set_horizontalalignment("left")
    axes.xaxis.label.set_x(0)
    axes.grid(False, axis="y")
    axes.spines["left"].set_visible(False)


def _bar(axes: Axes, k: int, name: str, share: float, shade: str, label: str) -> None:
    axes.barh(k + 0.16, 100 * share, BAR_HEIGHT, color=shade)
    axes.text(0, k - 0.2, name, fontsize=8.5, va="center", color=INK)
    axes.text(103, k + 0.16, label, fontsize=8, va="center", color=QUIET)


def _label(cause: Cause) -> str:
    share = f"{portion(cause.explained)}{f' of {cause.explained_of}' if cause.explained_of else ''}"
    return f"{share}, held out {cause.heldout_gain:+.2f}" if isfinite(cause.heldout_gain) else share


def _others(cause: Cause) -> list[str]:
    return [twin for twin in cause.twins if twin != cause.effect]
