"""Figures of a fit: parameters of all models side by side, and how the iteration went."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from robotid.estimate.result import Fits
from robotid.report.axes import INK, colour, dress, legend, plain

WIDTH = 0.6  # of the room that a parameter has, shared by the models


def draw_parameters(axes: Axes, fits: Fits) -> None:
    """Every estimated parameter over that of the best model, with two robust standard deviations."""
    best = fits.models[fits.best]
    shown = [p for p in best.parameters if not p.fixed and p.value]
    for k, (name, fit) in enumerate(fits.models.items()):
        ratio = np.array([fit[p.name].value / p.value for p in shown])
        spread = np.array([2 * fit[p.name].std_robust / abs(p.value) for p in shown])
        at = np.arange(len(shown)) + WIDTH * ((k + 0.5) / len(fits.models) - 0.5)
        axes.errorbar(at, ratio, spread, fmt="o", markersize=4, capsize=2.5, color=colour(k), linewidth=1.2, label=name)
    axes.axhline(1.0, color=INK, linewidth=0.6)
    axes.set_xticks(np.arange(len(shown)), [p.name.replace(".", "\n") for p in shown])
    dress(axes, "", f"value over that of {fits.best}", "Parameters, two standard deviations")
    axes.grid(False, axis="x")
    legend(axes, columns=len(fits.models))


def draw_iterations(axes: Axes, fits: Fits) -> None:
    """Cost of every model over its iterations, as a multiple of where it ended."""
    for k, (name, fit) in enumerate(fits.models.items()):
        axes.semilogy(fit.cost / fit.cost[-1], "o-", markersize=3, color=colour(k), linewidth=1.2, label=name)
    dress(axes, "iteration", "cost over its end", "Iterations")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    plain(axes.yaxis)
    legend(axes)
