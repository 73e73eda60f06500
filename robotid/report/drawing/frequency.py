"""Figures over frequency, 2 and 3 of the paper: the measured responses, and the linearised models beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MultipleLocator

from robotid.model.array import Array, Complex
from robotid.numerals import fixed
from robotid.report.evidence.response import Coherence, ModelResponse
from robotid.report.style.axes import (
    BLUE,
    FAINT,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    Units,
    axis_label,
    style_axes,
    write_out_ticks,
)
from robotid.signals.frf import Frf

Motion = Literal["acceleration", "speed"]
UNIT = {"acceleration": "rad/s2/Nm", "speed": "rad/s/Nm"}
MEASURED = (GREEN, PURPLE, ORANGE, SKY)
MODELS = (  # one alone, two or three: the start, the best, the extended one
    ((VERMILLION, "-"),),
    ((FAINT, "--"), (VERMILLION, "-")),
    ((FAINT, "--"), (VERMILLION, "-"), (BLUE, "-")),
)
DECIBEL_RANGE = 60.0  # from which ticks stand every 20 dB
PHASE_STEPS = (90.0, 45.0, 15.0, 5.0)  # [degrees] between ticks of a phase, the first of which two have room
MAX_PHASE_STEPS = 5  # of a phase axis, however many turns a phase unwraps over


@dataclass(frozen=True, slots=True, eq=False)
class Responses:
    """What a figure over frequency shows: measured responses, models by name, coherences by record."""

    measured: Sequence[Frf]
    models: Mapping[str, ModelResponse] = field(default_factory=dict)
    coherences: Mapping[str, Coherence] = field(default_factory=dict)

    @property
    def heights(self) -> tuple[float, ...]:
        """Of magnitude, phase and, where it is known, coherence."""
        return (2.2, 1.2, 0.8) if self.coherences else (2.2, 1.2)


def draw_responses(
    strips: Sequence[Axes], shown: Responses, motion: Motion = "acceleration", units: Units = str
) -> None:
    """Magnitude, phase and coherence from motor torque, one below the other, measured with two standard deviations."""
    magnitude, phase, *rest = strips
    for k, frf in enumerate(shown.measured):
        _measured(magnitude, phase, frf, motion, MEASURED[k % len(MEASURED)])
    for (name, model), (shade, line) in zip(shown.models.items(), _styles(len(shown.models)), strict=True):
        style: dict[str, Any] = {"color": shade, "linestyle": line, "linewidth": 1.3}
        response: Complex = getattr(model, motion)
        magnitude.plot(model.frequency, np.abs(response), label=_label(name, model), **style)
        phase.plot(model.frequency, _degrees(response), **style)
    magnitude.set_yscale("log")
    title = f"{axis_label('Motor torque', units)} to motor {motion}"
    style_axes(magnitude, "", f"magnitude\n[{units(UNIT[motion])}]", title)
    write_out_ticks(magnitude.yaxis)
    _decibels(magnitude)
    style_axes(phase, "", "phase [°]")
    tick_degrees(phase)
    for axes in rest:
        _coherence(axes, shown)
    for axes in strips:
        axes.set_xscale("log")
        write_out_ticks(axes.xaxis)
        axes.tick_params(labelbottom=axes is strips[-1])
    strips[-1].set_xlabel("frequency [Hz]", fontsize=9)


def tick_degrees(axes: Axes) -> None:
    """Ticks of a phase at parts of a turn, two of them at least unless it is all but constant."""
    low, high = axes.get_ylim()
    fitting = [step for step in PHASE_STEPS if high - low >= 2 * step]
    step = fitting[0] if fitting else PHASE_STEPS[-1]
    while high - low > MAX_PHASE_STEPS * step:
        step *= 2.0
    axes.yaxis.set_major_locator(MultipleLocator(step))


def _styles(count: int) -> Sequence[tuple[str, str]]:
    return MODELS[count - 1] if count else ()


def _measured(magnitude: Axes, phase: Axes, frf: Frf, motion: Motion, shade: str) -> None:
    """Points with bars: a band about a line would hide below it."""
    response = frf.response if motion == "acceleration" else frf.speed_response
    size = np.abs(response)
    # the error is complex: along the response and across it there is half of its variance each
    amount = np.abs(frf.response)
    relative = np.divide(frf.std, amount, out=np.zeros_like(amount), where=amount > 0.0) / np.sqrt(2.0)
    style: dict[str, Any] = {"fmt": "o", "color": shade, "markersize": 2.0, "elinewidth": 1.0, "alpha": 0.8}
    low = np.minimum(2 * relative, 0.95) * size
    magnitude.errorbar(frf.frequency, size, (low, 2 * relative * size), label=f"{frf.record}, measured", **style)
    phase.errorbar(frf.frequency, _degrees(response), np.minimum(np.degrees(2 * relative), 180.0), **style)


def _degrees(response: Complex) -> Array:
    """Phase, unwrapped from the lowest frequency on."""
    known = np.isfinite(response)
    found = np.full(len(response), np.nan)
    found[known] = np.degrees(np.unwrap(np.angle(response[known])))
    return found


def _decibels(axes: Axes) -> None:
    """The same scale in decibels, at the right."""
    right = axes.secondary_yaxis("right", functions=(_to_decibels, _from_decibels))
    right.set_yscale("linear")
    low, high = (float(_to_decibels(v)) for v in axes.get_ylim())
    right.yaxis.set_major_locator(MultipleLocator(20 if high - low > DECIBEL_RANGE else 10))
    right.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("-", "−")))
    right.set_ylabel("[dB]", fontsize=9)
    right.tick_params(labelsize=8, color=FAINT)
    right.spines["right"].set_color(FAINT)


def _to_decibels(value: Any) -> Any:
    return 20 * np.log10(np.maximum(value, 1e-300))


def _from_decibels(value: Any) -> Any:
    return 10 ** (np.asarray(value) / 20)


def _coherence(axes: Axes, shown: Responses) -> None:
    for k, frf in enumerate(shown.measured):
        if (found := shown.coherences.get(frf.record)) is not None:
            axes.plot(found.frequency, found.squared, color=MEASURED[k % len(MEASURED)], linewidth=1.2)
    axes.set_ylim(-0.03, 1.05)
    style_axes(axes, "", "coherence")


def _label(name: str, model: ModelResponse) -> str:
    """A model, and how far it is from the measured responses."""
    how = "simulated" if model.simulated else "linearised"
    return f"{name}, {how} ({fixed(model.distance, 1)} dB off)"
