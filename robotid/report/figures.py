"""Figures of what the stages make, each on one sheet. Drawn without any global state of matplotlib; `Figure.savefig`
writes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import singledispatch

from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from robotid.diagnosis.results import Diagnosis
from robotid.errors import ConfigError
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Fits
from robotid.estimate.rigid import RigidResult
from robotid.extension.results import Extension
from robotid.model.units import sliding
from robotid.report.drawing.causes import draw_causes, rows_of
from robotid.report.drawing.frequency import Responses
from robotid.report.drawing.gain import draw_gain, gains
from robotid.report.drawing.layout import draw_frequency, name_correlations, responses_figure
from robotid.report.drawing.location import Located, best_of_each, draw_curve, reach_of, telling
from robotid.report.drawing.parameters import draw_estimates, draw_iterations, draw_parameters, draw_torque_errors
from robotid.report.drawing.residual import draw_correlations
from robotid.report.drawing.time import (
    TimePlot,
    draw_strips,
    extended_plot,
    missing_plot,
    name_curves,
    record_plot,
    reference_plot,
    simulated_plot,
    trace_plot,
)
from robotid.report.evidence.response import validated_responses
from robotid.report.style.axes import Units, grid_of, new_figure
from robotid.signals.quality import Recordings
from robotid.signals.record import Quantity
from robotid.signals.reference import Excitation
from robotid.signals.trace import Trace
from robotid.validation.results import ModelValidation, RecordValidation, Validation

PANEL = (4.4, 3.4)  # width and height [inch] of a pair of axes
STRIP, MARGIN = 1.45, 0.6  # heights [inch] of a strip whose label is written along it, and of what is about all strips


@singledispatch
def draw(content: object, units: Units = str) -> Figure:
    """The figure of a stage's content. units : what a turning axis' unit is called here.

    Raises ConfigError where there is nothing to see.
    """
    raise ConfigError(
        "there is no figure of this",
        hint="excitations, records, rigid joints, responses, fits, validations, diagnoses and extensions have one",
    )


@draw.register
def draw_excitation(content: Excitation, units: Units = str) -> Figure:
    """The reference of every record."""
    if not content.references:
        raise ConfigError("no reference was made: all records are measured", hint="robotid show records.h5 --plot ...")
    return _sheet([reference_plot(reference, units) for reference in content.references])


@draw.register
def draw_recordings(content: Recordings, units: Units = str) -> Figure:
    """Torque and speed of every record."""
    return _sheet([record_plot(record, units) for record in content.records])


@draw.register
def draw_rigid(content: RigidResult, units: Units = str) -> Figure:
    """The parameters of the rigid joint with two standard deviations, and how far their torque is off by record."""
    figure = new_figure(9.0, 1.2 + 0.5 * max(len(content.parameters), len(content.torque_error_percent), 3))
    left, right = figure.subplots(1, 2)
    draw_estimates(left, content.parameters, units)
    draw_torque_errors(right, content.torque_error_percent, units)
    return figure


@draw.register
def draw_flexible(content: FlexResult, units: Units = str) -> Figure:
    """The measured responses from torque to acceleration."""
    if not content.frfs:
        raise ConfigError("no response was measured", hint="; ".join(content.remarks))
    return responses_figure(Responses(content.frfs), "acceleration", units)


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
    heights = [*([1.3 * tall] if content.frfs else []), grid, grid]
    figure = new_figure(max(9.0, PANEL[0] * columns), sum(heights))
    *above, middle, lower = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for subfigure in above:
        _bode(subfigure, content, units)
    _time_plots(middle, _traces(best, units))
    _correlations(lower, best, units)
    return figure


@draw.register
def draw_diagnosis(content: Diagnosis, units: Units = str) -> Figure:
    """Where the misfit sits, along every variable that tells something, and the ranking of causes below."""
    curves, bars = telling(best_of_each(content.curves)), rows_of(content)
    if not curves and not bars:
        if not content.missing:
            raise ConfigError("nothing is left to explain, so there is nothing to see")
        return _sheet([missing_plot(name, trace, units, causes=False) for name, trace in content.missing.items()])
    rows, columns = grid_of(len(curves)) if curves else (0, 1)
    heights = [*([PANEL[1] * rows] if curves else []), *([1.0 + 0.42 * bars] if bars else [])]
    figure = new_figure(max(6.4, PANEL[0] * columns), sum(heights))
    parts = list(figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0])
    if curves:
        panels = parts[0].subplots(rows, columns, squeeze=False).ravel()
        for axes in panels[len(curves) :]:
            axes.set_visible(False)
        for axes, curve in zip(panels, curves, strict=False):
            draw_curve(axes, Located(curve, units, tuple(content.missing), reach_of(curves)))
    if bars:
        draw_causes(parts[-1].subplots(), content)
    return figure


@draw.register
def draw_extension(content: Extension, units: Units = str) -> Figure:
    """The gain as a slope chart, and measured against simulated output before and after."""
    units = sliding if content.fit.structure.linear else units
    names = [name for name in content.after if name in content.before]
    plots = [extended_plot(content, name, units) for name in names]
    rows, columns = grid_of(max(1, len(plots)))
    figure = new_figure(max(8.0, PANEL[0] * columns), PANEL[1] * (1 + rows))
    above, below = figure.subfigures(2, 1, height_ratios=(1, rows), squeeze=False)[:, 0]
    groups = [used for used in (True, False) if gains(content, used=used)]
    draw_gain(list(above.subplots(1, len(groups), squeeze=False)[0]) if groups else [], content)
    _time_plots(below, plots)
    return figure


def draw_traces(traces: Mapping[str, Trace], output: Quantity, units: Units = str) -> Figure:
    """Measured and simulated output of some records, each under its title."""
    return _sheet([simulated_plot(title, trace, output, units) for title, trace in traces.items()])


def _bode(figure: FigureBase, content: Validation, units: Units) -> None:
    records = content.models[content.best].records
    shown = Responses(content.frfs, validated_responses(content, _sampling_time(records)))
    left, right = figure.subfigures(1, 2, squeeze=False)[0]
    draw_frequency(left, shown, "speed", units)
    draw_frequency(right, shown, "acceleration", units)


def _sampling_time(records: Mapping[str, RecordValidation]) -> float:
    return next((record.trace.sampling_time for record in records.values()), 1.0)


def _traces(model: ModelValidation, units: Units) -> list[TimePlot]:
    units = sliding if model.structure.linear else units
    return [trace_plot(name, record, model.output, units) for name, record in model.records.items()]


def _correlations(figure: FigureBase, model: ModelValidation, units: Units) -> None:
    units = sliding if model.structure.linear else units
    for pair, (name, record) in zip(_grid(figure, len(model.records), (1, 1)), model.records.items(), strict=True):
        draw_correlations(pair[0], pair[1], name, record.residual, record.trace.sampling_time, units)
    name_correlations(figure, units)


def _sheet(plots: Sequence[TimePlot]) -> Figure:
    rows, columns = grid_of(max(1, len(plots)))
    tall = max((len(plot.strips) for plot in plots), default=1)
    figure = new_figure(max(6.4, PANEL[0] * columns), max(PANEL[1], MARGIN + STRIP * tall) * rows)
    _time_plots(figure, plots)
    return figure


def _time_plots(figure: FigureBase, plots: Sequence[TimePlot]) -> None:
    """Plots in a grid, curves named once."""
    panels = _grid(figure, len(plots), plots[0].heights) if plots else []
    for strips, plot in zip(panels, plots, strict=True):
        draw_strips(strips, plot)
    name_curves(figure, [axes for strips in panels for axes in strips])


def _grid(figure: FigureBase, count: int, heights: Sequence[float]) -> list[list[Axes]]:
    """Stacks of axes in a grid."""
    if not count:
        return []
    rows, columns = grid_of(count)
    outer = figure.add_gridspec(rows, columns)
    stacks = []
    for k in range(count):
        inner = outer[divmod(k, columns)].subgridspec(len(heights), 1, height_ratios=list(heights))
        stacks.append([figure.add_subplot(inner[i]) for i in range(len(heights))])
    return stacks
