"""Every figure of a report, in order: the page shows them and `report --figures` writes them, one file each."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from robotid.estimate.result import FitResult
from robotid.judge.bode import Bode
from robotid.judge.diagnosis import Diagnosis, Extension
from robotid.judge.location import Curve
from robotid.judge.validation import ModelValidation, Validation
from robotid.report.axes import legend, new_figure
from robotid.report.causes import draw_causes, rows_of
from robotid.report.findings import Findings
from robotid.report.frequency import draw_bode, draw_responses
from robotid.report.gain import draw_gain, gains
from robotid.report.location import best_of_each, counted, draw_curve, draw_shape, reach_of, variable
from robotid.report.numbers import fixed, listed, significant
from robotid.report.parameters import draw_intervals, draw_iterations, interval_rows
from robotid.report.perturbation import draw_perturbation, perturbations
from robotid.report.residual import draw_correlations
from robotid.report.time import (
    TimePlot,
    draw_strips,
    extended_plot,
    missing_plot,
    record_plot,
    reference_plot,
    trace_plot,
)
from robotid.signals.frf import Frf

WIDTH, HEIGHT = 4.6, 3.1  # [inch] of a figure that a phone can show
TIME_WIDTH = 7.0  # of signals over time
MARGINS, LABEL = (0.85, 0.1, 0.5, 0.35), -0.52  # [inch] left, right, bottom, top of strips; where they are labelled


@dataclass(frozen=True, slots=True)
class Plate:
    """One figure. name : of its file, without ending. section : what it is about. alt : what is to be seen, in words.

    draw : makes the figure. plot : signals over time, which the page draws by itself so that they can be zoomed, and
    samples : how many the record has. wide : takes the whole width of a page.
    """

    name: str
    section: str
    title: str
    alt: str
    draw: Callable[[], Figure]
    plot: TimePlot | None = None
    samples: int = 0
    wide: bool = False


def plates(findings: Findings) -> tuple[Plate, ...]:
    """All figures that the findings allow."""
    return (
        *_traces(findings),
        *_responses(findings),
        *_parameters(findings),
        *_correlations(findings),
        *_places(findings),
        *_causes(findings),
        *_gain(findings),
        *_perturbation(findings),
        *_records(findings),
    )


def _traces(f: Findings) -> Iterator[Plate]:
    """Measured against simulated, by record: before and after where the model was extended."""
    section = "Measured against simulated"
    for name, plot, alt in _compared(f):
        yield _over_time(f"time-{name}", section, plot, alt, _length(f, name))


def _compared(f: Findings) -> Iterator[tuple[str, TimePlot, str]]:
    said = "Measured and simulated motor {} of {} over time, and the residual below: fit {} %"
    if f.extension is not None and f.extension.added:
        e = f.extension
        for name in (name for name in e.after if name in e.before):
            before, after = e.before[name], e.after[name]
            fits = f"{fixed(before.fit_percent)} % before and {fixed(after.fit_percent)}"
            yield (
                name,
                extended_plot(name, before, after, e.output, f.units),
                f"{said.format(e.output, name, fits)} after the extension.",
            )
    elif f.validation is not None:
        best = f.validation.models[f.validation.best]
        for name, record in best.records.items():
            plot = trace_plot(name, record, best.output, f.units)
            yield name, plot, f"{said.format(best.output, name, fixed(record.fit_percent))}."


def _length(f: Findings, name: str) -> int:
    """Samples of a record, 0 where it is not known."""
    return next((len(r) for r in f.recordings.records if r.name == name), 0) if f.recordings is not None else 0


def _responses(f: Findings) -> Iterator[Plate]:
    section = "Frequency responses"
    frfs = f.flex.frfs if f.flex is not None else ()
    if frfs:
        names = listed([frf.record for frf in frfs])
        alt = (
            f"Magnitude of the measured responses of {names} from motor torque to motor acceleration against frequency,"
            " with bands of two standard deviations."
        )
        yield Plate("responses", section, "Measured responses", alt, partial(responses_figure, frfs, f.units))
    models = {} if f.validation is None else bode_models(f.validation)
    if f.validation is not None and f.validation.frfs and models:
        for motion in ("speed", "acceleration"):
            alt = (
                f"Bode magnitude of {listed(list(models))}, linearised, from motor torque to motor {motion}, beside the"
                " measured responses with bands of two standard deviations."
            )
            draw = partial(_one, draw_bode, f.validation.frfs, models, motion, f.units)
            yield Plate(f"bode-{motion}", section, f"Model and measured responses, {motion}", alt, draw)


def bode_models(validation: Validation) -> dict[str, Bode]:
    """The model that the fits started from, and the best one."""
    names = dict.fromkeys((next(iter(validation.models)), validation.best))
    return {name: bode for name in names if (bode := validation.models[name].bode) is not None}


def _parameters(f: Findings) -> Iterator[Plate]:
    if f.fits is None:
        return
    fits = fitted(f)
    alt = f"Values of every parameter in {listed(list(fits))}, with intervals of two robust standard deviations."
    yield Plate("parameters", "Parameters", "Parameters with intervals", alt, partial(intervals_figure, fits, f.units))
    alt = f"Cost of {listed(list(f.fits.models))} over the iterations of their fit."
    yield Plate("iterations", "Parameters", "Iterations of the fits", alt, partial(_one, draw_iterations, f.fits))


def fitted(f: Findings) -> dict[str, FitResult]:
    """Every fit by the name of its model, the extended one last."""
    fits = {} if f.fits is None else dict(f.fits.models)
    if f.extension is not None and f.extension.added:
        fits[f"{f.extension.model} extended"] = f.extension.fit
    return fits


def _correlations(f: Findings) -> Iterator[Plate]:
    if f.validation is None:
        return
    best = f.validation.models[f.validation.best]
    for name, record in best.records.items():
        alt = f"Correlations of the residual of {name} with itself and with the torque, with bands at 99 %."
        alt = f"{alt} Verdict: {record.residual.verdict}."
        draw = partial(_correlation_figure, name, best)
        yield Plate(f"correlations-{name}", "What is left in the residual", name, alt, draw)


def _places(f: Findings) -> Iterator[Plate]:
    """Where the misfit sits: along every variable, and over time."""
    section = "Where the misfit sits"
    if f.diagnosis is None:
        return
    names, chosen = tuple(f.diagnosis.missing), best_of_each(f.diagnosis.curves)
    reach = reach_of(chosen)
    for curve in chosen:
        how = f"{counted(curve)} against {variable(curve)}, mean and spread in {len(curve.x)} bins"
        alt = f"Missing torque{how}: {_ordered(curve)}."
        draw = partial(_one, draw_curve, curve, f.units, names, reach)
        yield Plate(f"misfit-{_slug(curve.along)}", section, f"Along {variable(curve)}", alt, draw)
    if f.diagnosis.shape is not None and len(f.diagnosis.shape.x):
        curve = f.diagnosis.shape
        alt = f"The missing torque that no effect of the catalogue explains, against {variable(curve)}."
        draw = partial(_one, draw_shape, curve, f.units, names)
        yield Plate("unknown", section, "What no known effect explains", alt, draw)
    for name, missing in f.diagnosis.missing.items():
        plot = missing_plot(name, missing, f.units)
        alt = f"Missing torque of {name} over time: what the residual asks for, and what the causes supply."
        yield _over_time(f"missing-{name}", section, plot, alt, _length(f, name))


def _ordered(curve: Curve) -> str:
    if curve.along == "frequency":
        return f"the most at {significant(float(curve.x[int(np.nanargmax(curve.missing_torque))]), 2)} Hz"
    return f"it orders {fixed(100 * curve.order, 0)} % of its variance"


def _causes(f: Findings) -> Iterator[Plate]:
    if f.diagnosis is not None and rows_of(f.diagnosis):
        causes = listed([f"{c.effect} explains {fixed(100 * c.explained, 1)} %" for c in f.diagnosis.causes])
        alt = f"Effects ranked by the share of the misfit that they explain: {causes or 'none is a cause'}."
        yield Plate("causes", "Causes and gain", "Causes, ranked", alt, partial(causes_figure, f.diagnosis))


def _gain(f: Findings) -> Iterator[Plate]:
    if f.extension is not None and f.extension.added:
        pairs = gains(f.extension, used=True) | gains(f.extension, used=False)
        said = listed([f"{name} from {fixed(a)} to {fixed(b)} %" for name, (a, b) in pairs.items()])
        alt = f"Fit before and after the extension by record, held-out records apart: {said}."
        yield Plate(
            "gain", "Causes and gain", "Fit before and after the extension", alt, partial(gain_figure, f.extension)
        )


def _perturbation(f: Findings) -> Iterator[Plate]:
    if f.validation is None:
        return
    best = f.validation.models[f.validation.best]
    if found := perturbations(best):
        alt = f"Change of the fit of {f.validation.best} when one parameter at a time is raised or lowered."
        draw = partial(perturbation_figure, best)
        yield Plate("perturbation", "What each parameter is worth", "Change of the fit", alt, draw, wide=len(found) > 2)


def _records(f: Findings) -> Iterator[Plate]:
    if f.recordings is not None:
        for record in f.recordings.records:
            alt = f"Motor torque and motor speed of {record.name} over time."
            yield _over_time(f"record-{record.name}", "Records", record_plot(record, f.units), alt, len(record))
    elif f.excitation is not None:
        for reference in f.excitation.references:
            alt = f"Reference of {reference.name} over time."
            yield _over_time(f"reference-{reference.name}", "References", reference_plot(reference, f.units), alt)


def _over_time(name: str, section: str, plot: TimePlot, alt: str, samples: int = 0) -> Plate:
    return Plate(name, section, plot.title, alt, partial(time_figure, plot), plot, samples, wide=True)


def time_figure(plot: TimePlot) -> Figure:
    """Strips over time, their left edges in line."""
    wide, tall = TIME_WIDTH, 1.0 + 1.05 * sum(plot.heights)
    left, right, bottom, top = MARGINS
    figure = new_figure(wide, tall, None)
    figure.subplots_adjust(left / wide, bottom / tall, 1 - right / wide, 1 - top / tall, hspace=0.12)
    axes = figure.subplots(len(plot.strips), 1, squeeze=False, height_ratios=plot.heights)[:, 0]
    draw_strips(list(axes), plot)
    for one in axes:
        one.yaxis.set_label_coords(LABEL / (wide - left - right), 0.5)
    return figure


def responses_figure(frfs: Sequence[Frf], units: Callable[[str], str]) -> Figure:
    """Figure 2 of the paper."""
    figure = _one(draw_responses, frfs, "acceleration", units)
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


def _correlation_figure(name: str, model: ModelValidation) -> Figure:
    figure = new_figure(WIDTH, HEIGHT)
    upper, lower = figure.subplots(2, 1)
    draw_correlations(upper, lower, name, model.records[name].residual)
    return figure


def _one(draw: Callable[..., None], *arguments: Any) -> Figure:
    figure = new_figure(WIDTH, HEIGHT)
    draw(figure.subplots(), *arguments)
    return figure


def _slug(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-")
