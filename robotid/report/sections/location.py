"""Where the misfit sits: along every variable of the motion, and over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.model.companion import companion_of
from robotid.numerals import listed, portion, significant
from robotid.report.drawing.layout import one_figure
from robotid.report.drawing.location import (
    Located,
    best_of_each,
    counted,
    draw_curve,
    draw_shape,
    reach_of,
    telling,
    variable,
)
from robotid.report.drawing.time import TimePlot, missing_plot
from robotid.report.evidence.beyond import share_beyond
from robotid.report.evidence.companions import companion_curves
from robotid.report.evidence.samples import samples, stretches
from robotid.report.findings import Findings
from robotid.report.sections.section import Bin, FigureSpec, Section, over_time, slug
from robotid.report.style.axes import axis_label
from robotid.report.variables import MIN_SHARE
from robotid.signals.trace import Trace

NOTHING = 1e-3  # of the largest missing torque: what is less lies on the axis of the figure


class Location(Section):
    """The missing torque along the variables that order it, and over time."""

    title = "Where the misfit sits"

    def note(self, f: Findings) -> str:
        """A clean verdict stands above the figures."""
        clean = f.diagnosis is not None and f.diagnosis.verdict == "clean"
        return "The verdict is clean: what these figures show lies within the noise, so they are folded." * clean

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """Along every variable, those that a cause reads first, and over time. Variables that tell next to nothing,
        or nothing beyond the one that orders best, are folded away."""
        if f.diagnosis is None:
            return
        clean = f.diagnosis.verdict == "clean"
        names, chosen = tuple(f.diagnosis.missing), best_of_each(f.diagnosis.curves)
        reach = reach_of(chosen)
        read = {companion_of(cause.effect)[1] for cause in f.diagnosis.causes}
        companions = sorted(companion_curves(f), key=lambda curve: variable(curve) not in read)
        for curve in companions:
            located = Located(curve, f.units, names, reach_of([curve]), samples(f, curve))
            is_read = variable(curve) in read
            yield _along(f, located, folded=clean or (curve.order < MIN_SHARE and not is_read))
        shown = {curve.along for curve in _worth_seeing(f, chosen)}
        for curve in sorted(chosen, key=lambda c: c.along not in shown):
            located = Located(curve, f.units, names, reach, samples(f, curve))
            yield _along(f, located, folded=clean or curve.along not in shown)
        if f.diagnosis.shape is not None and len(f.diagnosis.shape.x):
            curve = f.diagnosis.shape
            missing = axis_label("missing torque", f.units)
            alt = f"The {missing} that no effect of the catalogue explains, against {variable(curve, f.units)}."
            draw = partial(one_figure, draw_shape, Located(curve, f.units, names))
            yield FigureSpec("unknown", "What no known effect explains", alt, draw)
        for name, trace in f.diagnosis.missing.items():
            law = f.evidence.laws.get(name)
            plot = missing_plot(name, trace, f.units, law, causes=bool(f.diagnosis.causes))
            parts = ["what the residual asks for"]
            parts += ["the law that the extension adds along its own motion"] * (law is not None)
            parts += ["what is still asked for once the causes are there"] * bool(f.diagnosis.causes)
            alt = f"{axis_label('Missing torque', f.units)} of {name} over time: {listed(parts)}."
            alt = f"{alt}{_nothing_left(trace) if f.diagnosis.causes else ''}{_beyond(plot, f)}"
            spec = over_time(f"missing-{name}", plot, alt, name, f.samples_of(name))
            yield replace(spec, folded=clean)


def _worth_seeing(f: Findings, curves: Sequence[Curve]) -> Iterator[Curve]:
    """The curve that orders best, and those that tell something beyond it. curves : the best first."""
    first: Curve | None = None
    for curve in telling(curves):
        if curve.along == "frequency" or first is None or share_beyond(f, first, curve) >= MIN_SHARE:
            yield curve
        if curve.along != "frequency":
            first = first or curve


def _nothing_left(missing: Trace) -> str:
    """Why a curve lies on zero: of a residual that is no more than noise the likeliest missing torque is none."""
    left, size = missing.measured - missing.simulated, float(np.abs(missing.measured).max(initial=0.0))
    if not np.any(missing.simulated) or float(np.abs(left).max(initial=0.0)) > NOTHING * size:
        return ""
    return " Once they are there, the residual is no more than noise and asks for nothing."


def _beyond(plot: TimePlot, f: Findings) -> str:
    """How far the law goes where it leaves the range, in a sentence."""
    values = np.concatenate([s.values[strip.beyond(s)] for strip in plot.strips for s in strip.series])
    if not len(values):
        return ""
    largest = f"{significant(float(values[np.argmax(np.abs(values))]), 2)} {f.units('Nm')}"
    return f" Triangles stand where the law goes beyond the range of what is asked for, up to {largest}."


def _along(f: Findings, located: Located, *, folded: bool) -> FigureSpec:
    curve = located.curve
    missing, what = counted(curve, f.units), variable(curve, f.units)
    alt = f"{missing[0].upper()}{missing[1:]}, against {what}: {_ordered(curve, what)}."
    if located.samples:
        alt += " Dots are samples, bands the spread in each bin"
        alt += ", the broken line is the law of the extension." if located.samples[0].law is not None else "."
    name = f"misfit-{slug(curve.along)}"
    draw = partial(one_figure, draw_curve, located)
    return FigureSpec(name, f"along {what}", alt, draw, folded=folded, bins=_bins(located, what, f))


def _bins(located: Located, what: str, f: Findings) -> tuple[Bin, ...]:
    """When each record is in each bin that is drawn."""
    curve, unit = located.curve, f.units(located.curve.unit)
    if not located.samples:
        return ()
    times = stretches(curve, located.samples)
    return tuple(
        Bin(f"{what} about {significant(float(x))} {unit}".strip(), times[k])
        for k, x in enumerate(curve.x)
        if np.isfinite(curve.missing_torque[k])
    )


def _ordered(curve: Curve, what: str) -> str:
    if curve.along == "frequency":
        return f"the most at {significant(float(curve.x[int(np.nanargmax(curve.missing_torque))]), 2)} Hz"
    the = "" if curve.along.startswith("companion[") else "the "
    share = f"{the}{what} accounts for {portion(curve.order, 0)} of its variance"
    return f"mean and spread in {len(curve.x)} bins; {share}"
