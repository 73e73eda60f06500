"""Figures over frequency, 2 and 3 of the paper: the measured responses, and the linearised models beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes

from robotid.numerals import fixed
from robotid.report.style.axes import FAINT, INK, Units, axis_label, colour, legend, style_axes, write_out_ticks
from robotid.signals.frf import Frf
from robotid.validation.results import Bode, Validation

Motion = Literal["acceleration", "speed"]
UNIT = {"acceleration": "rad/s2/Nm", "speed": "rad/s/Nm"}
STYLES = ("--", "-.", ":")
WIDTHS = (3.6, 2.0, 1.2)  # of measured responses, so that those below others are seen too


def draw_responses(axes: Axes, frfs: Sequence[Frf], motion: Motion = "acceleration", units: Units = str) -> None:
    """Figure 2: magnitude of the measured responses from motor torque, with a band of two standard deviations."""
    for k, frf in enumerate(frfs):
        response = frf.response if motion == "acceleration" else frf.speed_response
        magnitude = np.abs(response)
        spread = 2 * frf.std / (1.0 if motion == "acceleration" else frf.omega)
        low = np.maximum(magnitude - spread, 0.05 * magnitude)
        axes.fill_between(frf.frequency, low, magnitude + spread, color=colour(k), alpha=0.2, linewidth=0)
        axes.loglog(
            frf.frequency, magnitude, color=colour(k), linewidth=WIDTHS[min(k, 2)], label=f"{frf.record}, measured"
        )
    write_out_ticks(axes.xaxis)
    write_out_ticks(axes.yaxis)
    style_axes(
        axes,
        "frequency [Hz]",
        f"magnitude [{units(UNIT[motion])}]",
        f"{axis_label('Motor torque', units)} to motor {motion}",
    )


def draw_bode(
    axes: Axes, frfs: Sequence[Frf], models: Mapping[str, Bode], motion: Motion = "speed", units: Units = str
) -> None:
    """Figure 3: the measured responses and the magnitude of linearised models, at least one; the last stands out."""
    draw_responses(axes, frfs, motion, units)
    *before, last = models
    for k, name in enumerate(before):
        axes.plot(
            models[name].frequency,
            getattr(models[name], motion),
            color=FAINT,
            linestyle=STYLES[k % len(STYLES)],
            linewidth=1.2,
            label=_label(name, models[name]),
        )
    bode = models[last]
    axes.plot(bode.frequency, getattr(bode, motion), color=INK, linewidth=0.9, label=_label(last, bode))
    legend(axes, columns=2, below=True)


def _label(name: str, bode: Bode) -> str:
    """A model, and how far it is from the measured responses."""
    distance = sum(bode.distance.values()) / len(bode.distance)
    return f"{name}, linearised ({fixed(distance, 1)} dB off)"


def bode_models(validation: Validation) -> dict[str, Bode]:
    """The model that the fits started from, and the best one."""
    names = dict.fromkeys((next(iter(validation.models)), validation.best))
    return {name: bode for name in names if (bode := validation.models[name].bode) is not None}
