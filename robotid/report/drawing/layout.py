"""How the figures of a report are laid out: sizes, panels, margins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from matplotlib.figure import Figure, FigureBase

from robotid.diagnosis.results import Diagnosis
from robotid.estimate.result import FitResult
from robotid.extension.results import Extension
from robotid.report.drawing.causes import draw_causes, rows_of
from robotid.report.drawing.frequency import Motion, Responses, draw_responses
from robotid.report.drawing.gain import draw_gain, gains
from robotid.report.drawing.parameters import draw_intervals, interval_rows, shown_parameters
from robotid.report.drawing.perturbation import draw_perturbation, perturbations
from robotid.report.drawing.residual import correlation_keys, draw_correlations
from robotid.report.drawing.time import TimePlot, draw_strips, name_curves
from robotid.report.style.axes import Units, new_figure
from robotid.validation.results import ModelValidation

WIDTH, HEIGHT = 4.6, 3.1  # [inch] of a figure that a phone can show
FREQUENCY_WIDTH = 5.4  # of responses
TIME_WIDTH = 7.0  # of signals over time
MAX_STRIPS = 4  # of parameters one below the other


def time_figure(plot: TimePlot) -> Figure:
    """Strips over time, their left edges in line."""
    figure = new_figure(TIME_WIDTH, 1.25 + 1.05 * sum(plot.heights))
    axes = list(figure.subplots(len(plot.strips), 1, squeeze=False, height_ratios=plot.heights)[:, 0])
    draw_strips(axes, plot)
    name_curves(figure, axes)
    figure.align_ylabels(axes)
    return figure


def responses_figure(shown: Responses, motion: Motion, units: Units) -> Figure:
    """Magnitude, phase and coherence over frequency."""
    rows = -(-(len(shown.measured) + len(shown.models)) // 2)
    figure = new_figure(FREQUENCY_WIDTH, 0.9 + sum(shown.heights) + 0.2 * rows)
    draw_frequency(figure, shown, motion, units)
    return figure


def draw_frequency(figure: FigureBase, shown: Responses, motion: Motion, units: Units) -> None:
    """The same on a part of a figure."""
    strips = list(figure.subplots(len(shown.heights), 1, squeeze=False, height_ratios=shown.heights)[:, 0])
    draw_responses(strips, shown, motion, units)
    handles, names = strips[0].get_legend_handles_labels()
    figure.legend(handles, names, fontsize=8, frameon=False, ncols=2, loc="outside lower center")


def causes_figure(diagnosis: Diagnosis) -> Figure:
    """The ranking of causes."""
    figure = new_figure(WIDTH, 0.8 + 0.42 * rows_of(diagnosis))
    draw_causes(figure.subplots(), diagnosis)
    return figure


def gain_figure(extension: Extension) -> Figure:
    """The slope chart of the extension."""
    groups = [used for used in (True, False) if gains(extension, used=used)]
    figure = new_figure(WIDTH, 0.2 + 2.1 * max(1, len(groups)))
    draw_gain(list(figure.subplots(len(groups), 1, squeeze=False)[:, 0]) if groups else [], extension)
    return figure


def has_two_columns(fits: Mapping[str, FitResult]) -> bool:
    """Whether the intervals of these fits stand in two columns, which take the width of a page."""
    return len(shown_parameters(fits)) > MAX_STRIPS


def intervals_figure(fits: Mapping[str, FitResult], units: Units, extended: str | None = None) -> Figure:
    """Parameters with intervals, a strip a parameter. extended : the model whose extension is the last one, if any."""
    heights = [0.5 + 0.17 * rows for rows in interval_rows(fits)]
    columns = 2 if has_two_columns(fits) else 1
    rows = -(-len(heights) // columns)
    tall = [max(heights[k::rows]) for k in range(rows)]
    figure = new_figure(WIDTH * columns, 0.3 + sum(tall))
    if heights:
        axes = figure.subplots(rows, columns, squeeze=False, height_ratios=tall).T.ravel()
        for one in axes[len(heights) :]:
            one.set_visible(False)
        draw_intervals(list(axes[: len(heights)]), fits, units, extended)
    return figure


def perturbation_figure(model: ModelValidation) -> Figure:
    """The heat map of perturbed parameters."""
    found = perturbations(model)
    rows = len(next(iter(found.values())).names)
    figure = new_figure(1.9 + 1.3 * len(found), 1.7 + 0.3 * rows)
    draw_perturbation(figure.subplots(), model)
    return figure


def matrix_figure(draw: Callable[..., None], size: int, *arguments: Any) -> Figure:
    """A heat map of so many rows and columns, with names on two sides."""
    figure = new_figure(max(WIDTH, 2.0 + 0.42 * size), 2.6 + 0.3 * size)
    draw(figure.subplots(), *arguments)
    return figure


def correlation_figure(name: str, model: ModelValidation, units: Units = str) -> Figure:
    """Correlations of the residual of one record."""
    figure = new_figure(WIDTH, HEIGHT + 0.35)
    upper, lower = figure.subplots(2, 1)
    record = model.records[name]
    draw_correlations(upper, lower, name, record.residual, record.trace.sampling_time, units)
    name_correlations(figure, units)
    return figure


def name_correlations(figure: FigureBase, units: Units = str) -> None:
    """A legend of colours and bands below all axes."""
    handles, names = correlation_keys(units)
    figure.legend(handles, names, fontsize=8, frameon=False, ncols=2, loc="outside lower center")


def one_figure(draw: Callable[..., None], *arguments: Any) -> Figure:
    """A figure of one pair of axes."""
    figure = new_figure(WIDTH, HEIGHT)
    draw(figure.subplots(), *arguments)
    return figure
