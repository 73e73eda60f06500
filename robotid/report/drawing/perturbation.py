"""Table 3 of the paper as a heat map: what each parameter is worth to the fit of each record."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap

from robotid.model.array import Array
from robotid.report.drawing.heat_map import Cells, draw_cells
from robotid.validation.results import ModelValidation, Perturbation

LIGHTEST, DARKEST = 0.08, 0.93  # of the colour map that is used
LEAST = 0.1  # [% points] below which changes can hardly be distinguished by their shade
NONE_SEEN = 0.005  # [%] what two decimals do not show


def perturbations(model: ModelValidation) -> dict[str, Perturbation]:
    """By record, of those on which parameters were perturbed, held-out records first."""
    found = {name: record.perturbation for name, record in model.records.items() if record.perturbation.names}
    return dict(sorted(found.items(), key=lambda item: model.records[item[0]].used))


def draw_perturbation(axes: Axes, model: ModelValidation) -> None:
    """A row a parameter, two columns a record: raised, lowered. The darker, the more of the fit is lost."""
    found = perturbations(model)
    first = next(iter(found.values()))
    change = np.stack([side for p in found.values() for side in (p.plus, p.minus)], axis=1)
    kinds = {name: "fitted" if model.records[name].used else "held out" for name in found}
    signs = [f"{name}\n{kinds[name]}\n{sign}{first.percent:g} %" for name in found for sign in ("+", "\u2212")]
    largest = max(float(np.nanmax(-change, initial=0.0)), LEAST)
    levels = [level for level in (0.0, 0.1, 1.0, 10.0, 100.0, 1000.0) if level <= largest]
    ticks = tuple((float(_shade(np.array(level), largest)), f"{level:g}".replace("-", "")) for level in levels)
    blues = ListedColormap(colormaps["Blues"](np.linspace(LIGHTEST, DARKEST, 256)))
    texts = tuple(tuple(_figures(value) for value in row) for row in change.tolist())
    shades = np.where(np.isfinite(change), _shade(np.maximum(-np.nan_to_num(change), 0.0), largest), np.nan)
    cells = Cells(shades, texts, first.names, signs, blues, ticks=ticks)
    draw_cells(axes, cells, "Change of the fit [% points]", "fit that is lost [% points]")


def _shade(lost: Array, largest: float) -> Array:
    """How dark each cell is, 0 to 1: logarithmic, as changes run from hundredths to hundreds."""
    return np.asarray(np.log1p(lost / LEAST) / np.log1p(largest / LEAST))


def _figures(value: float) -> str:
    """Three digits, as few as a cell has room for. A gain has a sign, as its cell has the colour of no loss."""
    if not np.isfinite(value):
        return "diverges"
    size = abs(value)
    decimals = 2 if size < 10 else 1 if size < 100 else 0
    return "0" if size < NONE_SEEN else f"{'+' * (value > 0)}{value:.{decimals}f}".replace("-", "\u2212")
