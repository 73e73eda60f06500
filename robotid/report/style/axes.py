"""How all figures look: colours that colour-blind readers can tell apart, light grids, units on every axis."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, ScalarFormatter

from robotid.model.array import Array
from robotid.model.units import sliding_words, typeset
from robotid.numerals import significant

Units = Callable[[str], str]

# Okabe & Ito 2008, without the yellow that vanishes on paper
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
BLUE, VERMILLION, GREEN, PURPLE, SKY, ORANGE = PALETTE
INK, QUIET, FAINT, BAND, GRID = "#222222", "#5C6166", "#9A9A9A", "#DDE6EE", "#E4E4E4"
ROUNDING = 1e-9  # of the largest tick: one below it is zero
TICK_DIGITS = 6  # of a tick of a logarithmic axis: where it spans less than a decade they are no round numbers
MAX_DECADES = 2.5  # that ticks at 1, 2, 5 have room on
MAX_POINTS = 4000  # drawn of a signal; a longer one is drawn as its envelope


def new_figure(width: float, height: float, layout: Literal["constrained"] | None = "constrained") -> Figure:
    """An empty figure [inch] that no global state knows of. layout : constrained, as much room as the labels need."""
    return Figure(figsize=(width, height), dpi=110, layout=layout, facecolor="white")


def axis_label(quantity: str, units: Units) -> str:
    """A quantity in the words of its axis: one that slides has forces and positions."""
    return sliding_words(quantity) if units("rad") == "m" else quantity


def colour(k: int) -> str:
    """Colour of the k-th curve."""
    return PALETTE[k % len(PALETTE)]


def style_axes(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Labels, grid, and no frame beyond the two axes. Ticks are written out: none is to be added to what stands beside
    the axis. Powers of units are raised."""
    axes.set_xlabel(typeset(x), fontsize=9)
    axes.set_ylabel(typeset(y), fontsize=9)
    axes.set_title(typeset(title), fontsize=10, loc="left", color=INK)
    axes.tick_params(labelsize=8, color=FAINT)
    axes.grid(True, which="major", color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    for axis in (axes.xaxis, axes.yaxis):
        if isinstance(axis.get_major_formatter(), ScalarFormatter):
            axis.set_major_formatter(PlainTicks(useOffset=False))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(FAINT)


class PlainTicks(ScalarFormatter):
    """Ticks with their power of ten in them, none to be multiplied by what stands beside the axis."""

    _largest = 0.0

    def set_locs(self, locs: Any) -> None:
        super().set_locs(locs)
        self._largest = float(np.abs(locs).max()) if len(locs) else 0.0

    def __call__(self, x: float, pos: int | None = None) -> str:
        if not super().get_offset():
            return super().__call__(x, pos)
        return self.fix_minus(significant(x if abs(x) > ROUNDING * self._largest else 0.0, TICK_DIGITS))

    def get_offset(self) -> str:
        return ""


def legend(axes: Axes, columns: int = 1, *, below: bool = False) -> Legend | None:
    """A legend without a frame, where curves have names; below the axes where they are full of curves."""
    if not axes.get_legend_handles_labels()[1]:
        return None
    if below:
        return axes.legend(fontsize=8, frameon=False, ncols=columns, loc="upper center", bbox_to_anchor=(0.5, -0.16))
    return axes.legend(fontsize=8, frameon=False, ncols=columns)


def write_out_ticks(axis: Axis) -> None:
    """Ticks of a logarithmic axis written out, at 1, 2, 5 unless it spans many decades."""
    low, high = axis.get_view_interval()
    few = high > low * 10**MAX_DECADES
    axis.set_major_locator(LogLocator(subs=(1.0,) if few else (1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: significant(value, TICK_DIGITS).removeprefix("1·")))
    axis.set_minor_formatter(NullFormatter())


def widen(axis: Axis, least: float) -> None:
    """Let an axis span so much of its largest value at least, that a smaller change looks like none, and its ticks show
    no more digits than anybody reads."""
    low, high = axis.get_view_interval()
    room = least * max(abs(low), abs(high)) / 2
    if high - low < 2 * room:
        axis.set_view_interval((low + high) / 2 - room, (low + high) / 2 + room, ignore=True)


def envelope(t: Array, signal: Array, most: int = MAX_POINTS) -> tuple[Array, Array]:
    """A signal for drawing, (n,): of a long one the least and the largest of every stretch, in the order of time."""
    if len(signal) <= most:
        return t, signal
    count = most // 2
    edges = np.linspace(0, len(signal), count + 1).astype(int)
    stretches = list(pairwise(edges.tolist()))
    lowest = [a + int(np.argmin(signal[a:b])) for a, b in stretches]
    highest = [a + int(np.argmax(signal[a:b])) for a, b in stretches]
    at = np.unique([*lowest, *highest])
    return t[at], signal[at]


def grid_of(count: int, most_columns: int = 3) -> tuple[int, int]:
    """Rows and columns for so many panels."""
    columns = min(count, most_columns)
    return -(-count // columns), columns
