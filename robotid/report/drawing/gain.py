"""The gain of an extension as a slope chart: fit before and after, record by record, held-out records apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from robotid.extension.results import Extension
from robotid.model.array import Array
from robotid.numerals import fixed
from robotid.report.style.axes import BLUE, GRID, INK, VERMILLION, style_axes

GAP = 0.1  # between labels, share of the height
GROUPS = {"records of the fit": True, "held-out records": False}


def gains(extension: Extension, *, used: bool) -> dict[str, tuple[float, float]]:
    """Fit before and after [%] by record, of those that the model was fitted to or of the others."""
    return {
        name: (extension.before[name].fit_percent, score.fit_percent)
        for name, score in extension.after.items()
        if score.used is used and name in extension.before
    }


def draw_gain(panels: Sequence[Axes], extension: Extension, groups: Sequence[str] = tuple(GROUPS)) -> None:
    """Slope charts on a common scale, one for the records of the fit and one for those held out, as far as there are
    any: a panel each. groups : of these alone."""
    found = {title: gains(extension, used=GROUPS[title]) for title in groups}
    shown = {title: group for title, group in found.items() if group}
    values = [value for group in shown.values() for pair in group.values() for value in pair]
    low, high = min(values, default=0.0), max(values, default=100.0)
    room = 0.1 * (high - low) or 0.5
    for axes, (title, group) in zip(panels, shown.items(), strict=True):
        axes.set_ylim(low - room, high + room)
        _slopes(axes, group)
        style_axes(axes, "", "fit [%]", title)
        axes.grid(False, axis="x")
        axes.set_xlim(-0.1, 1.95)
        axes.set_xticks([0, 1], ["before", "after"])
        axes.spines["bottom"].set_visible(False)
        axes.tick_params(axis="x", length=0)


def _slopes(axes: Axes, group: dict[str, tuple[float, float]]) -> None:
    for at in (0, 1):
        axes.axvline(at, color=GRID, linewidth=0.8, zorder=0)
    names = sorted(group, key=lambda name: group[name][1])
    bottom, top = axes.get_ylim()
    heights = _apart(np.array([group[name][1] for name in names]), GAP * (top - bottom))
    for name, height in zip(names, heights.tolist(), strict=True):
        before, after = group[name]
        shade = BLUE if after >= before else VERMILLION
        axes.plot([0, 1], [before, after], "o-", color=shade, markersize=4.5, linewidth=1.6)
        axes.annotate(
            f"{name}: {fixed(before)} → {fixed(after)}",
            (1, after),
            (1.08, height),
            fontsize=8,
            va="center",
            color=INK,
        )


def _apart(heights: Array, gap: float) -> Array:
    """Rising heights moved as little as it takes to leave a gap between neighbours."""
    steps = gap * np.arange(len(heights))
    risen = np.maximum.accumulate(heights - steps)
    fallen = np.minimum.accumulate((heights - steps)[::-1])[::-1]
    return np.asarray((risen + fallen) / 2 + steps)
