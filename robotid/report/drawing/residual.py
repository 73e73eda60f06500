"""Figures of what is left in the residual: its correlations, and its spectrum."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from robotid.model.array import Array, Mask
from robotid.report.evidence.spectrum import ResidualSpectra
from robotid.report.style.axes import (
    BAND,
    BLUE,
    FAINT,
    INK,
    QUIET,
    VERMILLION,
    Units,
    axis_label,
    legend,
    style_axes,
    write_out_ticks,
)
from robotid.validation.results import ResidualTest

MILLI = 1000.0  # lags are shown in milliseconds


def draw_correlations(
    upper: Axes, lower: Axes, name: str, test: ResidualTest, sampling_time: float, units: Units = str
) -> None:
    """Correlation of the residual with itself above, with the torque below; the band that all bars keep to together in
    99 of 100 records, and the bars beyond it, which are the verdict. Bars that do not count are faint."""
    lags = np.arange(1, len(test.autocorrelation) + 1) * sampling_time * MILLI
    beyond = _stems(upper, lags, test.autocorrelation, test.band, np.ones(len(lags), dtype=bool))
    verdict = "white" if test.white else f"coloured, {beyond} of {len(lags)} bars beyond the band"
    style_axes(upper, "", "with itself", f"{name}: {verdict}")
    half = len(test.crosscorrelation) // 2
    lags = np.arange(-half, half + 1) * sampling_time * MILLI
    beyond = _stems(lower, lags, test.crosscorrelation, test.cross_band, lags > 0)
    torque = axis_label("torque", units)
    verdict = f"follows the {torque}, {beyond} of {half} bars beyond the band"
    if test.undecided:
        verdict = "too short a record to tell: the band is wider than 1"
    elif test.independent:
        verdict = f"no sign of the {torque}"
    style_axes(lower, "lag [ms]", f"with the {torque}", verdict)
    lower.axvline(0.0, color=FAINT, linewidth=0.6)


def _stems(axes: Axes, lags: NDArray[np.floating[Any]], values: Array, band: float, counts: Mask) -> int:
    """Bars by whether they count and lie beyond the band; returns how many do both."""
    axes.axhspan(-band, band, color=BAND, linewidth=0)
    outside = counts & (np.abs(values) > band)
    for where, shade in ((~counts, FAINT), (counts & ~outside, BLUE), (outside, VERMILLION)):
        axes.vlines(lags[where], 0.0, values[where], color=shade, linewidth=1.4)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    reach = 1.25 * max(float(np.abs(values).max(initial=0.0)), 1.5 * band) or 1.0  # nothing is left of a record
    axes.set_ylim(-reach, reach)
    return int(outside.sum())


def correlation_keys(units: Units = str) -> tuple[list[Line2D | Patch], list[str]]:
    """What colours and band mean."""
    lines: list[Line2D | Patch] = [Line2D([], [], color=shade, linewidth=1.6) for shade in (BLUE, VERMILLION, FAINT)]
    feedback = f"before the {axis_label('torque', units)}: feedback, not counted"
    return [*lines, Patch(color=BAND)], ["within", "beyond", feedback, "99 % band"]


def draw_spectra(axes: Axes, name: str, spectra: ResidualSpectra, unit: str) -> None:
    """What a model leaves over frequency, before and after its extension, and the noise alone."""
    axes.fill_between(spectra.frequency, 0.0, spectra.noise, color=BAND, linewidth=0)
    axes.loglog(spectra.frequency, spectra.noise, color=QUIET, linewidth=1.0, linestyle="--", label="noise floor")
    last = spectra.before if spectra.after is None else spectra.after
    if spectra.after is not None:
        axes.loglog(spectra.frequency, spectra.before, color=VERMILLION, linewidth=1.4, label="before the extension")
    label = "residual" if spectra.after is None else "after it"
    axes.loglog(spectra.frequency, last, color=BLUE, linewidth=1.4, label=label)
    shown = np.concatenate([spectra.before, last, spectra.noise])
    shown = shown[np.isfinite(shown) & (shown > 0)]
    if len(shown):
        axes.set_ylim(0.5 * shown.min(), 2.0 * shown.max())
    write_out_ticks(axes.xaxis)
    write_out_ticks(axes.yaxis)
    style_axes(axes, "frequency [Hz]", f"residual [{unit}/√Hz]", f"{name}: residual over frequency")
    legend(axes, columns=3, below=True)
