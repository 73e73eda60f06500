"""Every figure of a report, in order: the page shows them and `report --figures` writes them, one file each."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from robotid.diagnosis.misfit.location import Curve
from robotid.estimate.result import FitResult
from robotid.report.axes import axis_label
from robotid.report.causes import rows_of
from robotid.report.findings import Findings
from robotid.report.frequency import draw_bode
from robotid.report.gain import gains
from robotid.report.layout import (
    causes_figure,
    correlation_figure,
    gain_figure,
    intervals_figure,
    one_figure,
    perturbation_figure,
    responses_figure,
    time_figure,
)
from robotid.report.location import best_of_each, counted, draw_curve, draw_shape, reach_of, variable
from robotid.report.numbers import fixed, listed, percent, significant
from robotid.report.parameters import draw_iterations
from robotid.report.perturbation import perturbations
from robotid.report.time import (
    TimePlot,
    extended_plot,
    missing_plot,
    record_plot,
    reference_plot,
    trace_plot,
)
from robotid.validation.bode import Bode
from robotid.validation.results import Validation

PLACES = "Where the misfit sits"


@dataclass(frozen=True, slots=True)
class FigureSpec:
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


def figure_specs(findings: Findings) -> tuple[FigureSpec, ...]:
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


def _traces(f: Findings) -> Iterator[FigureSpec]:
    """Measured against simulated, by record: before and after where the model was extended."""
    section = "Measured against simulated"
    for name, plot, alt in _compared(f):
        yield _over_time(f"time-{name}", section, plot, alt, _length(f, name))


def _compared(f: Findings) -> Iterator[tuple[str, TimePlot, str]]:
    text = "Measured and simulated motor {} of {} over time, and the residual below: fit {} %"
    if f.extension is not None and f.extension.added:
        e = f.extension
        for name in (name for name in e.after if name in e.before):
            before, after = e.before[name], e.after[name]
            fits = f"{fixed(before.fit_percent)} % before and {fixed(after.fit_percent)}"
            yield (
                name,
                extended_plot(name, before, after, e.output, f.units),
                f"{text.format(e.output, name, fits)} after the extension.",
            )
    elif f.validation is not None:
        best = f.validation.models[f.validation.best]
        for name, record in best.records.items():
            plot = trace_plot(name, record, best.output, f.units)
            yield name, plot, f"{text.format(best.output, name, fixed(record.fit_percent))}."


def _length(f: Findings, name: str) -> int:
    """Samples of a record, 0 where it is not known."""
    return next((len(r) for r in f.recordings.records if r.name == name), 0) if f.recordings is not None else 0


def _responses(f: Findings) -> Iterator[FigureSpec]:
    """Measured responses, beside those of the models where there are any."""
    section = "Frequency responses"
    frfs = f.flex.frfs if f.flex is not None else ()
    models = {} if f.validation is None else bode_models(f.validation)
    validated = f.validation if f.validation is not None and f.validation.frfs and models else None
    if frfs and validated is None:
        names = listed([frf.record for frf in frfs])
        alt = (
            f"Magnitude of the measured responses of {names} from motor torque to motor acceleration against frequency,"
            " with bands of two standard deviations."
        )
        yield FigureSpec("responses", section, "Measured responses", alt, partial(responses_figure, frfs, f.units))
    if validated is not None:
        for motion in ("speed", "acceleration"):
            alt = (
                f"Bode magnitude of {listed(list(models))}, linearised, from motor torque to motor {motion}, beside the"
                " measured responses with bands of two standard deviations."
            )
            draw = partial(one_figure, draw_bode, validated.frfs, models, motion, f.units)
            yield FigureSpec(f"bode-{motion}", section, f"Model and measured responses, {motion}", alt, draw)


def bode_models(validation: Validation) -> dict[str, Bode]:
    """The model that the fits started from, and the best one."""
    names = dict.fromkeys((next(iter(validation.models)), validation.best))
    return {name: bode for name in names if (bode := validation.models[name].bode) is not None}


def _parameters(f: Findings) -> Iterator[FigureSpec]:
    if f.fits is None:
        return
    fits = fitted(f)
    alt = f"Values of every parameter in {listed(list(fits))}, with intervals of two robust standard deviations."
    yield FigureSpec(
        "parameters", "Parameters", "Parameters with intervals", alt, partial(intervals_figure, fits, f.units)
    )
    alt = f"Cost of {listed(list(f.fits.models))} over the iterations of their fit."
    yield FigureSpec(
        "iterations", "Parameters", "Iterations of the fits", alt, partial(one_figure, draw_iterations, f.fits)
    )


def fitted(f: Findings) -> dict[str, FitResult]:
    """Every fit by the name of its model, the extended one last."""
    fits = {} if f.fits is None else dict(f.fits.models)
    if f.extension is not None and f.extension.added:
        fits[f"{f.extension.model} extended"] = f.extension.fit
    return fits


def _correlations(f: Findings) -> Iterator[FigureSpec]:
    if f.validation is None:
        return
    best = f.validation.models[f.validation.best]
    for name, record in best.records.items():
        alt = f"Correlations of the residual of {name} with itself and with the torque, with bands at 99 %."
        alt = f"{alt} Verdict: {record.residual.verdict}."
        draw = partial(correlation_figure, name, best)
        yield FigureSpec(f"correlations-{name}", "What is left in the residual", name, alt, draw)


def _places(f: Findings) -> Iterator[FigureSpec]:
    """Where the misfit sits: along every variable, and over time."""
    if f.diagnosis is None:
        return
    names, chosen = tuple(f.diagnosis.missing), best_of_each(f.diagnosis.curves)
    reach = reach_of(chosen)
    for curve in chosen:
        missing, what = counted(curve, f.units), variable(curve, f.units)
        alt = f"{missing[0].upper()}{missing[1:]}, against {what}: {_ordered(curve, what)}."
        draw = partial(one_figure, draw_curve, curve, f.units, names, reach)
        yield FigureSpec(f"misfit-{_slug(curve.along)}", PLACES, f"Along {what}", alt, draw)
    if f.diagnosis.shape is not None and len(f.diagnosis.shape.x):
        curve = f.diagnosis.shape
        missing = axis_label("missing torque", f.units)
        alt = f"The {missing} that no effect of the catalogue explains, against {variable(curve, f.units)}."
        draw = partial(one_figure, draw_shape, curve, f.units, names)
        yield FigureSpec("unknown", PLACES, "What no known effect explains", alt, draw)
    for name, trace in f.diagnosis.missing.items():
        plot = missing_plot(name, trace, f.units, supplied=bool(f.diagnosis.causes))
        supplied = ", and what the causes supply" if f.diagnosis.causes else ""
        alt = f"{axis_label('Missing torque', f.units)} of {name} over time: what the residual asks for{supplied}."
        yield _over_time(f"missing-{name}", PLACES, plot, alt, _length(f, name))


def _ordered(curve: Curve, what: str) -> str:
    if curve.along == "frequency":
        return f"the most at {significant(float(curve.x[int(np.nanargmax(curve.missing_torque))]), 2)} Hz"
    share = f"the {what} orders {percent(curve.order, 0)} % of its variance"
    return f"mean and spread in {len(curve.x)} bins; {share}"


def _causes(f: Findings) -> Iterator[FigureSpec]:
    if f.diagnosis is not None and rows_of(f.diagnosis):
        causes = listed([f"{c.effect} explains {percent(c.explained)} %" for c in f.diagnosis.causes])
        alt = f"Effects ranked by the share of the misfit that they explain: {causes or 'none is a cause'}."
        yield FigureSpec("causes", "Causes and gain", "Causes, ranked", alt, partial(causes_figure, f.diagnosis))


def _gain(f: Findings) -> Iterator[FigureSpec]:
    if f.extension is not None and f.extension.added:
        pairs = gains(f.extension, used=True) | gains(f.extension, used=False)
        text = listed([f"{name} from {fixed(a)} to {fixed(b)} %" for name, (a, b) in pairs.items()])
        alt = f"Fit before and after the extension by record, held-out records apart: {text}."
        yield FigureSpec(
            "gain", "Causes and gain", "Fit before and after the extension", alt, partial(gain_figure, f.extension)
        )


def _perturbation(f: Findings) -> Iterator[FigureSpec]:
    if f.validation is None:
        return
    best = f.validation.models[f.validation.best]
    if found := perturbations(best):
        alt = f"Change of the fit of {f.validation.best} when one parameter at a time is raised or lowered."
        draw = partial(perturbation_figure, best)
        yield FigureSpec(
            "perturbation", "What each parameter is worth", "Change of the fit", alt, draw, wide=len(found) > 2
        )


def _records(f: Findings) -> Iterator[FigureSpec]:
    if f.recordings is not None:
        for record in f.recordings.records:
            alt = f"{axis_label('Motor torque', f.units)} and motor speed of {record.name} over time."
            yield _over_time(f"record-{record.name}", "Records", record_plot(record, f.units), alt, len(record))
    elif f.excitation is not None:
        for reference in f.excitation.references:
            alt = f"Reference of {reference.name} over time."
            yield _over_time(f"reference-{reference.name}", "References", reference_plot(reference, f.units), alt)


def _over_time(name: str, section: str, plot: TimePlot, alt: str, samples: int = 0) -> FigureSpec:
    return FigureSpec(name, section, plot.title, alt, partial(time_figure, plot), plot, samples, wide=True)


def _slug(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-")
