"""How the figures of a report are laid out: sizes, panels, margins."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from robotid.diagnosis.results import Diagnosis
from robotid.estimate.result import FitResult
from robotid.extension.results import Extension
from robotid.report.drawing.causes import draw_causes, rows_of
from robotid.report.drawing.frequency import draw_responses
from robotid.report.drawing.gain import draw_gain, gains
from robotid.report.drawing.parameters import draw_intervals, interval_rows
from robotid.report.drawing.perturbation import draw_perturbation, perturbations
from robotid.report.drawing.residual import draw_correlations
from robotid.report.drawing.time import TimePlot, draw_strips, name_curves
from robotid.report.style.axes import legend, new_figure
from robotid.signals.frf import Frf
from robotid.validation.results import ModelValidation

WIDTH, HEIGHT = 4.6, 3.1  # [inch] of a figure that a phone can show
TIME_WIDTH = 7.0  # of signals over time
MARGINS, LABEL = (0.85, 0.1, 0.75, 0.35), -0.52  # [inch] left, right, bottom, top of strips; where they are labelled


def time_figure(plot: TimePlot) -> Figure:
    """Strips over time, their left edges in line."""
    wide, tall = TIME_WIDTH, 1.25 + 1.05 * sum(plot.heights)
    left, right, bottom, top = MARGINS
    figure = new_figure(wide, tall, None)
    figure.subplots_adjust(left / wide, bottom / tall, 1 - right / wide, 1 - top / tall, hspace=0.12)
    axes = list(figure.subplots(len(plot.strips), 1, squeeze=False, height_ratios=plot.heights)[:, 0])
    draw_strips(axes, plot)
    name_curves(figure, axes)
    for one in axes:
        one.yaxis.set_label_coords(LABEL / (wide - left - right), 0.5)
    return figure


def responses_figure(frfs: Sequence[Frf], units: Callable[[str], str]) -> Figure:
    """Figure 2 of the paper."""
    figure = one_figure(draw_responses, frfs, "acceleration", units)
    legend(figure.axes[0], columns=2, below=True)
    return figure


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


def intervals_figure(fits: Mapping[str, FitResult], units: Callable[[str], str]) -> Figure:
    """Parameters with intervals, a strip a parameter."""
    heights = [0.5 + 0.17 * rows for rows in interval_rows(fits)]
    figure = new_figure(WIDTH, 0.3 + sum(heights))
    if heights:
        axes = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)
        draw_intervals(list(axes[:, 0]), fits, units)
    return figure


def perturbation_figure(model: ModelValidation) -> Figure:
    """The heat map of perturbed parameters."""
    found = perturbations(model)
    rows = len(next(iter(found.values())).names)
    figure = new_figure(1.7 + 1.3 * len(found), 0.8 + 0.3 * rows)
    draw_perturbation(figure.subplots(), found)
    return figure


def correlation_figure(name: str, model: ModelValidation) -> Figure:
    """Correlations of the residual of one record."""
    figure = new_figure(WIDTH, HEIGHT)
    upper, lower = figure.subplots(2, 1)
    draw_correlations(upper, lower, name, model.records[name].residual)
    return figure


def one_figure(draw: Callable[..., None], *arguments: Any) -> Figure:
    """A figure of one pair of axes."""
    figure = new_figure(WIDTH, HEIGHT)
    draw(figure.subplots(), *arguments)
    return figure
