"""Figures over time and lag: records, measured against simulated output, and what is left in the residual."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from robotid.judge.validation import RecordValidation
from robotid.judge.whiteness import ResidualTest
from robotid.model.array import Array
from robotid.report.axes import BAND, FAINT, INK, PALETTE, Units, dress, envelope
from robotid.signals.record import Quantity, Record

BLUE, RED = PALETTE[0], PALETTE[1]
OUTPUT = {"speed": "motor speed [{}]", "position": "motor position [{}]"}
UNIT = {"speed": "rad/s", "position": "rad"}


def draw_record(upper: Axes, lower: Axes, record: Record, units: Units = str) -> None:
    """Torque above, speed below, with the reference where it is one of speed."""
    upper.plot(*envelope(record.t, record.tau_m), color=BLUE, linewidth=0.7)
    dress(upper, "", f"motor torque [{units('Nm')}]", f"{record.name} ({record.role})")
    if record.ref is not None and record.ref_kind == "speed":
        lower.plot(*envelope(record.t, record.ref), color=FAINT, linewidth=0.6, label="reference")
    lower.plot(*envelope(record.t, record.dphi_m), color=BLUE, linewidth=0.9, label="measured")
    dress(lower, "time [s]", f"motor speed [{units('rad/s')}]")
    upper.tick_params(labelbottom=False)


def draw_trace(
    upper: Axes, lower: Axes, name: str, validation: RecordValidation, output: Quantity, units: Units = str
) -> None:
    """Measured and simulated output above, their difference below."""
    trace = validation.trace
    unit = units(UNIT[output])
    upper.plot(*envelope(trace.t, trace.measured), color=FAINT, linewidth=2.4, label="measured")
    upper.plot(*envelope(trace.t, trace.simulated), color=BLUE, linewidth=0.8, label="simulated")
    kind = "fitted" if validation.used else "held out"
    dress(upper, "", OUTPUT[output].format(unit), f"{name} ({kind}): fit {validation.fit_percent:.2f} %")
    upper.tick_params(labelbottom=False)
    lower.plot(*envelope(trace.t, trace.measured - trace.simulated), color=RED, linewidth=0.6)
    lower.axhline(0.0, color=INK, linewidth=0.6)
    dress(lower, "time [s]", f"residual\n[{unit}]")


def draw_correlations(upper: Axes, lower: Axes, name: str, test: ResidualTest) -> None:
    """Correlation of the residual with itself above, with the torque below, and their bands at 99 %."""
    lags = np.arange(1, len(test.autocorrelation) + 1)
    _stems(upper, lags, test.autocorrelation, test.band)
    dress(upper, "", "with itself", f"{name}: residual, {'white' if test.white else 'coloured'}")
    half = len(test.crosscorrelation) // 2
    _stems(lower, np.arange(-half, half + 1), test.crosscorrelation, test.cross_band)
    told = "no sign of the torque" if test.independent else "follows the torque"
    dress(lower, "lag [samples]", "with the torque", told)
    lower.axvline(0.0, color=FAINT, linewidth=0.6)


def _stems(axes: Axes, lags: NDArray[np.int_], values: Array, band: float) -> None:
    axes.axhspan(-band, band, color=BAND, linewidth=0)
    outside = np.abs(values) > band
    for where, shade in ((~outside, BLUE), (outside, RED)):
        axes.vlines(lags[where], 0.0, values[where], color=shade, linewidth=1.4)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    reach = 1.25 * max(float(np.abs(values).max(initial=0.0)), 1.5 * band)
    axes.set_ylim(-reach, reach)
