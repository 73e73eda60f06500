"""Heat maps: cells of one colour each with a number in letters that can be read, beside the scale of the colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.patches import Rectangle

from robotid.model.array import Array
from robotid.report.style.axes import FAINT, style_axes

ON_LIGHT, ON_DARK = "#101010", "#fefefe"
STEPS = 40  # of the scale of the colours
MAX_LEVEL = 10  # characters of a head that is not turned
DARK = 0.45  # luminance below which letters are white


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """shades (rows, columns) : 0 to 1 on the colour map, nan where unknown; texts alike; span : what 0 and 1 stand for;
    ticks : of the scale, on the same 0 to 1, with their texts, absent: those of the span."""

    shades: Array
    texts: Sequence[Sequence[str]]
    rows: Sequence[str]
    columns: Sequence[str]
    colours: Colormap
    span: tuple[float, float] = (0.0, 1.0)
    ticks: tuple[tuple[float, str], ...] = ()


def draw_cells(axes: Axes, cells: Cells, title: str, scale: str) -> None:
    """A heat map under a title. scale : what the colours stand for."""
    for (row, column), shade in np.ndenumerate(cells.shades):
        fill = cells.colours(float(shade)) if np.isfinite(shade) else FAINT
        axes.add_patch(Rectangle((column + 0.03, row + 0.04), 0.94, 0.92, facecolor=fill, linewidth=0))
        text = cells.texts[row][column]
        if text:
            size = 8.0 if len(text) < 6 else 6.5
            axes.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=size, color=_ink(fill))
    rows, columns = cells.shades.shape
    axes.set_xlim(0, columns)
    axes.set_ylim(rows, 0)
    turned = max((len(line) for name in cells.columns for line in name.splitlines()), default=0) > MAX_LEVEL
    axes.set_xticks(np.arange(columns) + 0.5, cells.columns, rotation=90 if turned else 0)
    axes.set_yticks(np.arange(rows) + 0.5, cells.rows)
    style_axes(axes, "", "", title)
    axes.xaxis.tick_top()
    axes.grid(False)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    _colour_bar(axes, cells, scale)


def _colour_bar(axes: Axes, cells: Cells, scale: str) -> None:
    # so few steps are drawn one by one: more would be a picture inside the page
    mapped = ScalarMappable(Normalize(*((0.0, 1.0) if cells.ticks else cells.span)), cells.colours.resampled(STEPS))
    bar = axes.figure.colorbar(mapped, ax=axes, orientation="horizontal", fraction=0.06, pad=0.03, aspect=40)
    bar.outline.set_visible(False)
    if bar.solids is not None:
        bar.solids.set_edgecolor("face")
    bar.set_label(scale, fontsize=8)
    bar.ax.tick_params(labelsize=8, length=2)
    if not cells.ticks:
        bar.set_ticks(np.linspace(*cells.span, 5).tolist())
    else:
        bar.set_ticks([at for at, _ in cells.ticks], labels=[text for _, text in cells.ticks])


def _ink(fill: tuple[float, float, float, float] | str) -> str:
    if isinstance(fill, str):
        return ON_LIGHT
    red, green, blue = fill[:3]
    return ON_DARK if 0.2126 * red + 0.7152 * green + 0.0722 * blue < DARK else ON_LIGHT
