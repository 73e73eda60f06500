"""Table 3 of the paper as a heat map: what each parameter is worth to the fit of each record."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from robotid.model.array import Array
from robotid.report.style.axes import FAINT, style_axes
from robotid.validation.results import ModelValidation, Perturbation

DARK = 0.55  # of the scale: from here on white figures
ON_LIGHT, ON_DARK = "#101010", "#fefefe"
NONE_SEEN = 0.005  # [%] what two decimals do not show


def perturbations(model: ModelValidation) -> dict[str, Perturbation]:
    """By record, of those on which parameters were perturbed."""
    return {name: record.perturbation for name, record in model.records.items() if record.perturbation.names}


def draw_perturbation(axes: Axes, found: Mapping[str, Perturbation]) -> None:
    """A row a parameter, two columns a record: raised, lowered. The darker, the more of the fit is lost."""
    names = next(iter(found.values())).names
    columns = [side for p in found.values() for side in (p.plus, p.minus)]
    change = np.stack(columns, axis=1)
    shades = _shades(change)
    for (row, column), value in np.ndenumerate(change):
        _cell(axes, row, column, float(value), float(shades[row, column]))
    axes.set_xlim(0, change.shape[1])
    axes.set_ylim(len(names), 0)
    percent = next(iter(found.values())).percent
    signs = [f"{name}\n{sign}{percent:g} %" for name in found for sign in ("+", "−")]
    axes.set_xticks(np.arange(change.shape[1]) + 0.5, signs)
    axes.set_yticks(np.arange(len(names)) + 0.5, names)
    style_axes(axes, "", "", "Change of the fit [% points]")
    axes.xaxis.tick_top()
    axes.grid(False)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def _shades(change: Array) -> Array:
    """How dark each cell is, 0 to 1: logarithmic, as changes run from hundredths to hundreds."""
    lost = np.log1p(np.maximum(-np.nan_to_num(change, nan=0.0), 0.0) / 0.1)
    return np.asarray(lost / (lost.max() or 1.0))


def _cell(axes: Axes, row: int, column: int, value: float, shade: float) -> None:
    known = np.isfinite(value)
    fill = colormaps["Blues"](0.08 + 0.85 * shade) if known else FAINT
    axes.add_patch(Rectangle((column + 0.03, row + 0.04), 0.94, 0.92, facecolor=fill, linewidth=0))
    ink = ON_DARK if known and shade > DARK else ON_LIGHT
    axes.text(column + 0.5, row + 0.5, _figures(value), ha="center", va="center", fontsize=8, color=ink)


def _figures(value: float) -> str:
    """Three digits, as few as a cell has room for."""
    if not np.isfinite(value):
        return "diverges"
    size = abs(value)
    decimals = 2 if size < 10 else 1 if size < 100 else 0
    return "0" if size < NONE_SEEN else f"{value:.{decimals}f}".replace("-", "−")
