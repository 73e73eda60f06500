"""Figures of what is left in the residual."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from robotid.model.array import Array
from robotid.report.style.axes import BAND, BLUE, FAINT, INK, VERMILLION, style_axes
from robotid.validation.results import ResidualTest


def draw_correlations(upper: Axes, lower: Axes, name: str, test: ResidualTest) -> None:
    """Correlation of the residual with itself above, with the torque below, and their bands at 99 %."""
    lags = np.arange(1, len(test.autocorrelation) + 1)
    _stems(upper, lags, test.autocorrelation, test.band)
    style_axes(upper, "", "with itself", f"{name}: residual, {'white' if test.white else 'coloured'}")
    half = len(test.crosscorrelation) // 2
    _stems(lower, np.arange(-half, half + 1), test.crosscorrelation, test.cross_band)
    title = "no sign of the torque" if test.independent else "follows the torque"
    style_axes(lower, "lag [samples]", "with the torque", title)
    lower.axvline(0.0, color=FAINT, linewidth=0.6)


def _stems(axes: Axes, lags: NDArray[np.int_], values: Array, band: float) -> None:
    axes.axhspan(-band, band, color=BAND, linewidth=0)
    outside = np.abs(values) > band
    for where, shade in ((~outside, BLUE), (outside, VERMILLION)):
        axes.vlines(lags[where], 0.0, values[where], color=shade, linewidth=1.4)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    reach = 1.25 * max(float(np.abs(values).max(initial=0.0)), 1.5 * band)
    axes.set_ylim(-reach, reach)
