"""Figures of a fit: parameters of all models side by side, and how the iteration went."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import floor, log10
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from robotid.estimate.result import Estimate, FitResult, Fits
from robotid.model.units import typeset_unit
from robotid.numerals import number, ten_to
from robotid.report.style.axes import (
    BLUE,
    INK,
    PALETTE,
    VERMILLION,
    Units,
    axis_label,
    colour,
    legend,
    style_axes,
    widen,
    write_out_ticks,
)

WIDTH = 0.6  # of the room that a parameter has, shared by the models
MARK: Final[dict[str, Any]] = {"markersize": 4.5, "capsize": 3, "linewidth": 1.4}
NARROWEST = 1e-5  # range of a strip, of its largest value
LEAST_FALL = 0.02  # range of costs, of the largest: two per cent of a sum of squares is one of the error
MIN_COST = 1e-18  # of the largest: what rounding leaves of a fit without noise
SMALLEST = 1e-100  # value of a parameter, in SI units, that another may be a multiple of
WIDE_RANGE = 5.0  # of costs, from which a logarithmic scale serves better


def draw_parameters(axes: Axes, fits: Fits) -> None:
    """Every estimated parameter over that of the best model, with two robust standard deviations."""
    best = fits.models[fits.best]
    shown = [p for p in best.parameters if not p.fixed and abs(p.value) > SMALLEST]
    for k, (name, fit) in enumerate(fits.models.items()):
        ratio = np.array([fit[p.name].value / p.value for p in shown])
        spread = np.array([2 * fit[p.name].std_robust / abs(p.value) for p in shown])
        at = np.arange(len(shown)) + WIDTH * ((k + 0.5) / len(fits.models) - 0.5)
        axes.errorbar(at, ratio, spread, fmt="o", markersize=4, capsize=2.5, color=colour(k), linewidth=1.2, label=name)
    axes.axhline(1.0, color=INK, linewidth=0.6)
    axes.set_xticks(np.arange(len(shown)), [p.name.replace(".", "\n") for p in shown])
    style_axes(axes, "", f"value over that of {fits.best}", "Parameters, two standard deviations")
    axes.grid(False, axis="x")
    legend(axes, columns=len(fits.models))


def draw_estimates(axes: Axes, estimates: Sequence[Estimate], units: Units = str) -> None:
    """Two robust standard deviations of every estimate in percent of its value, which stands beside it."""
    for row, p in enumerate(estimates):
        spread = 200 * p.std_robust / abs(p.value) if p.value and np.isfinite(p.std_robust) else 0.0
        axes.errorbar(0.0, row, xerr=spread, fmt="o", color=colour(0), **MARK)
    unit = [typeset_unit(units(p.unit)) for p in estimates]
    names = [f"{p.name}\n{number(p.value, 4)} {'' if u == '1' else u}" for p, u in zip(estimates, unit, strict=True)]
    axes.set_yticks(range(len(estimates)), names)
    axes.set_ylim(len(estimates) - 0.4, -0.6)
    style_axes(axes, "two standard deviations [% of the value]", "", "Parameters of the rigid joint")


def draw_torque_errors(axes: Axes, errors: Mapping[str, float], units: Units = str) -> None:
    """How far the rigid joint's torque is off, a bar a record."""
    axes.barh(range(len(errors)), list(errors.values()), 0.5, color=colour(0))
    axes.set_yticks(range(len(errors)), list(errors))
    axes.set_ylim(len(errors) - 0.4, -0.6)
    what = axis_label("torque", units)
    style_axes(axes, f"{what} that is not met [%]", "", f"Error of the {what}")
    axes.grid(False, axis="y")


def draw_iterations(axes: Axes, fits: Fits) -> None:
    """Cost of every model over its iterations, as a multiple of where it ended."""
    ends = [max(float(fit.cost[-1]), MIN_COST * float(fit.cost.max())) or 1.0 for fit in fits.models.values()]
    for k, (name, fit) in enumerate(fits.models.items()):
        axes.plot(fit.cost / ends[k], "o-", markersize=3, color=colour(k), linewidth=1.2, label=name)
    if max(fit.cost.max() / end for fit, end in zip(fits.models.values(), ends, strict=True)) > WIDE_RANGE:
        axes.set_yscale("log")
        write_out_ticks(axes.yaxis)
    else:
        widen(axes.yaxis, LEAST_FALL)
    style_axes(axes, "iteration", "cost over its end", "Iterations")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    legend(axes)


def shown_parameters(fits: Mapping[str, FitResult]) -> list[Estimate]:
    """Parameters that any of the fits estimated, in the order of the last."""
    found: dict[str, Estimate] = {}
    for fit in reversed(list(fits.values())):
        for p in fit.parameters:
            if not p.fixed:
                found.setdefault(p.name, p)
    return list(found.values())


def interval_colours(names: Sequence[str], extended: str | None = None) -> dict[str, str]:
    """A colour for each model. extended : the one that was extended, whose extension is the last: before and after have
    the colours that they have in every figure."""
    if extended is None:
        return {name: colour(k) for k, name in enumerate(names)}
    others = [name for name in names[:-1] if name != extended]
    rest = [shade for shade in PALETTE if shade not in (BLUE, VERMILLION)]
    found = {name: rest[k % len(rest)] for k, name in enumerate(others)}
    return found | {extended: VERMILLION, names[-1]: BLUE}


def draw_intervals(
    pairs: Sequence[Axes], fits: Mapping[str, FitResult], units: Units = str, extended: str | None = None
) -> None:
    """A strip a parameter, a row a model: value and two robust standard deviations, each on its own scale. extended :
    as of `interval_colours`."""
    colours = interval_colours(list(fits), extended)
    for axes, parameter in zip(pairs, shown_parameters(fits), strict=True):
        found = {name: p for name, fit in fits.items() if (p := _estimated(fit, parameter.name)) is not None}
        scale = _scale(found.values())
        for row, (name, p) in enumerate(reversed(found.items())):
            spread = 2 * p.std_robust / scale if np.isfinite(p.std_robust) else 0.0
            axes.errorbar(p.value / scale, row, xerr=spread, fmt="o", color=colours[name], **MARK)
        axes.set_ylim(-0.6, len(found) - 0.4)
        axes.set_yticks(range(len(found)), list(found)[::-1])
        style_axes(axes, "", "", f"{parameter.name}{_unit(units(parameter.unit), scale)}")
        axes.grid(False, axis="y")
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.margins(x=0.08)
        widen(axes.xaxis, NARROWEST)
        axes.ticklabel_format(axis="x", style="plain")


def interval_rows(fits: Mapping[str, FitResult]) -> list[int]:
    """Rows of each strip of `draw_intervals`."""
    return [sum(_estimated(fit, p.name) is not None for fit in fits.values()) for p in shown_parameters(fits)]


def _estimated(fit: FitResult, name: str) -> Estimate | None:
    return next((p for p in fit.parameters if p.name == name and not p.fixed), None)


def _scale(estimates: Iterable[Estimate]) -> float:
    """A power of a thousand that makes the values handy."""
    largest = max(abs(p.value) for p in estimates)
    return 1.0 if not largest or 1e-3 <= largest < 1e5 else 1e3 ** floor(log10(largest) / 3)


def _unit(unit: str, scale: float) -> str:
    power = "" if scale == 1.0 else ten_to(round(log10(scale)))
    text = " ".join(filter(None, (power, "" if unit == "1" else unit)))
    return f" [{text}]" if text else ""
