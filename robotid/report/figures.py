"""Figures of what the stages make. Drawn without any global state of matplotlib; `Figure.savefig` writes them."""

from __future__ import annotations

from functools import singledispatch

from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from robotid.errors import ConfigError
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Fits
from robotid.judge.validation import ModelValidation, Validation
from robotid.model.units import sliding
from robotid.report.axes import Units, grid_of, legend, new_figure
from robotid.report.frequency import draw_bode, draw_responses
from robotid.report.parameters import draw_iterations, draw_parameters
from robotid.report.time import draw_correlations, draw_record, draw_trace
from robotid.signals.quality import Recordings

PANEL = (4.4, 3.4)  # width and height [inch] of a pair of axes


@singledispatch
def draw(content: object, units: Units = str) -> Figure:
    """The figure of a stage's content. units : what a turning axis' unit is called here.

    Raises ConfigError where there is nothing to see.
    """
    raise ConfigError(
        f"there is no figure of a {type(content).__name__}", hint="records, responses, fits and validations have one"
    )


@draw.register
def draw_recordings(content: Recordings, units: Units = str) -> Figure:
    """Torque and speed of every record."""
    records = content.records
    figure, pairs = _pairs_figure(len(records), (1, 1.4))
    for pair, record in zip(pairs, records, strict=True):
        draw_record(*pair, record, units)
        if record is records[0]:
            legend(pair[1])
    return figure


@draw.register
def draw_flexible(content: FlexResult, units: Units = str) -> Figure:
    """Figure 2 of the paper: magnitudes of the measured responses from torque to acceleration."""
    if not content.frfs:
        raise ConfigError("no response was measured", hint="; ".join(content.remarks))
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    draw_responses(axes, content.frfs, "acceleration", units)
    legend(axes)
    return figure


@draw.register
def draw_fits(content: Fits, units: Units = str) -> Figure:
    """Parameters of all models side by side, and their iterations."""
    figure = new_figure(10.5, 4.0)
    left, right = figure.subplots(1, 2, width_ratios=(2.6, 1))
    draw_parameters(left, content)
    draw_iterations(right, content)
    return figure


@draw.register
def draw_validation(content: Validation, units: Units = str) -> Figure:
    """Of the best model: Figure 3 of the paper, measured against simulated output, and the residual's correlations."""
    best = content.models[content.best]
    rows, columns = grid_of(max(1, len(best.records)))
    grid, tall = PANEL[1] * rows, PANEL[1]
    heights = [*([tall] if content.frfs else []), grid, grid]
    figure = new_figure(max(9.0, PANEL[0] * columns), sum(heights))
    *above, middle, lower = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for subfigure in above:
        _bode(subfigure, content, units)
    _traces(middle, best, units)
    _correlations(lower, best)
    return figure


def bode_figure(content: Validation, units: Units = str) -> Figure:
    """Figure 3 of the paper, torque to speed, and the same to acceleration."""
    figure = new_figure(10.0, 4.2)
    _bode(figure, content, units)
    return figure


def trace_figure(model: ModelValidation, units: Units = str) -> Figure:
    """Measured and simulated output on every record, with a strip of their difference."""
    rows, columns = grid_of(len(model.records))
    figure = new_figure(max(6.4, PANEL[0] * columns), PANEL[1] * rows)
    _traces(figure, model, units)
    return figure


def correlation_figure(model: ModelValidation) -> Figure:
    """Correlations of the residual on every record."""
    rows, columns = grid_of(len(model.records))
    figure = new_figure(max(6.4, PANEL[0] * columns), PANEL[1] * rows)
    _correlations(figure, model)
    return figure


def _bode(figure: FigureBase, content: Validation, units: Units) -> None:
    names = list(dict.fromkeys((next(iter(content.models)), content.best)))
    models = {name: bode for name in names if (bode := content.models[name].bode) is not None}
    left, right = figure.subplots(1, 2)
    draw_bode(left, content.frfs, models, "speed", units)
    draw_bode(right, content.frfs, models, "acceleration", units)


def _traces(figure: FigureBase, model: ModelValidation, units: Units) -> None:
    units = sliding if model.structure.linear else units
    for pair, (name, record) in zip(_pairs(figure, len(model.records), (2.6, 1)), model.records.items(), strict=True):
        draw_trace(*pair, name, record, model.output, units)
        if name == next(iter(model.records)):
            legend(pair[0])


def _correlations(figure: FigureBase, model: ModelValidation) -> None:
    for pair, (name, record) in zip(_pairs(figure, len(model.records), (1, 1)), model.records.items(), strict=True):
        draw_correlations(*pair, name, record.residual)


def _pairs_figure(count: int, heights: tuple[float, float]) -> tuple[Figure, list[tuple[Axes, Axes]]]:
    rows, columns = grid_of(count)
    figure = new_figure(max(6.4, PANEL[0] * columns), PANEL[1] * rows)
    return figure, _pairs(figure, count, heights)


def _pairs(figure: FigureBase, count: int, heights: tuple[float, float]) -> list[tuple[Axes, Axes]]:
    """Pairs of axes, one above the other on a common abscissa, in a grid."""
    if not count:
        return []
    rows, columns = grid_of(count)
    outer = figure.add_gridspec(rows, columns)
    pairs = []
    for k in range(count):
        inner = outer[divmod(k, columns)].subgridspec(2, 1, height_ratios=heights)
        upper, lower = figure.add_subplot(inner[0]), figure.add_subplot(inner[1])
        pairs.append((upper, lower))
    return pairs
