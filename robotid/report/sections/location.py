"""Where the misfit sits: along every variable of the motion, and over time."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.numerals import percent, significant
from robotid.report.drawing.layout import one_figure
from robotid.report.drawing.location import best_of_each, counted, draw_curve, draw_shape, reach_of, variable
from robotid.report.drawing.time import missing_plot
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section, over_time
from robotid.report.style.axes import axis_label


class Location(Section):
    """The missing torque along the variables that order it, and over time."""

    title = "Where the misfit sits"

    def note(self, f: Findings) -> str:
        """A clean verdict stands above the figures."""
        clean = f.diagnosis is not None and f.diagnosis.verdict == "clean"
        return "The verdict is clean: what these figures show lies within the noise." * clean

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """Along every variable, and over time."""
        if f.diagnosis is None:
            return
        names, chosen = tuple(f.diagnosis.missing), best_of_each(f.diagnosis.curves)
        reach = reach_of(chosen)
        for curve in chosen:
            missing, what = counted(curve, f.units), variable(curve, f.units)
            alt = f"{missing[0].upper()}{missing[1:]}, against {what}: {_ordered(curve, what)}."
            draw = partial(one_figure, draw_curve, curve, f.units, names, reach)
            yield FigureSpec(f"misfit-{_slug(curve.along)}", f"Along {what}", alt, draw)
        if f.diagnosis.shape is not None and len(f.diagnosis.shape.x):
            curve = f.diagnosis.shape
            missing = axis_label("missing torque", f.units)
            alt = f"The {missing} that no effect of the catalogue explains, against {variable(curve, f.units)}."
            draw = partial(one_figure, draw_shape, curve, f.units, names)
            yield FigureSpec("unknown", "What no known effect explains", alt, draw)
        for name, trace in f.diagnosis.missing.items():
            plot = missing_plot(name, trace, f.units, supplied=bool(f.diagnosis.causes))
            supplied = ", and what the causes supply" if f.diagnosis.causes else ""
            alt = f"{axis_label('Missing torque', f.units)} of {name} over time: what the residual asks for{supplied}."
            yield over_time(f"missing-{name}", plot, alt, f.samples_of(name))


def _ordered(curve: Curve, what: str) -> str:
    if curve.along == "frequency":
        return f"the most at {significant(float(curve.x[int(np.nanargmax(curve.missing_torque))]), 2)} Hz"
    share = f"the {what} orders {percent(curve.order, 0)} % of its variance"
    return f"mean and spread in {len(curve.x)} bins; {share}"


def _slug(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-")
