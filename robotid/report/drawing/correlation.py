"""The correlations of the estimates of a fit as a heat map."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes

from robotid.estimate.result import Estimate, FitResult
from robotid.model.array import Array
from robotid.report.drawing.heat_map import Cells, draw_cells

NOTED = 0.3  # size from which a correlation is written into its cell


def estimated(fit: FitResult) -> list[Estimate]:
    """The parameters that have a variance."""
    variance = np.diag(fit.covariance_robust)
    return [p for p, v in zip(fit.parameters, variance, strict=True) if not p.fixed and np.isfinite(v) and v > 0]


def correlation(fit: FitResult) -> Array:
    """Of the estimated parameters, robust to coloured residuals, (p, p)."""
    names = [p.name for p in fit.parameters]
    at = [names.index(p.name) for p in estimated(fit)]
    covariance = fit.covariance_robust[np.ix_(at, at)]
    deviation = np.sqrt(np.diag(covariance))
    return np.asarray(np.clip(covariance / np.outer(deviation, deviation), -1.0, 1.0))


def draw_correlation(axes: Axes, name: str, fit: FitResult) -> None:
    """A row and a column a parameter, blue where two rise together, red where one rises as the other falls."""
    found, names = correlation(fit), [p.name for p in estimated(fit)]
    texts = [
        [f"{value:.2f}".replace("-", "\u2212") if abs(value) >= NOTED else "" for value in row]
        for row in found.tolist()
    ]
    shades = (1 + found) / 2
    cells = Cells(shades, tuple(map(tuple, texts)), tuple(names), tuple(names), colormaps["RdBu"], (-1.0, 1.0))
    draw_cells(axes, cells, f"Correlation of the estimates\nof {name}", "correlation")
