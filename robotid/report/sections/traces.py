"""Measured against simulated, by record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from robotid.numerals import fixed, significant
from robotid.report.drawing.time import TimePlot, extended_plot, trace_plot
from robotid.report.events import given, left_in
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section, over_time


class Traces(Section):
    """Measured and simulated signals of each record, before and after where the model was extended."""

    title = "Measured against simulated"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """One of each record."""
        for name, plot, alt in _compared(f):
            plot = replace(plot, compact=f.is_clean(name))
            yield over_time(f"time-{name}", plot, alt, name, f.samples_of(name))


def _in_pieces(f: Findings) -> str:
    """What makes the residual jump where a fit simulates pieces of its records."""
    if f.pieces is None:
        return ""
    return f" Simulated in pieces of {significant(f.pieces)} s, each from a first state of its own."


def _compared(f: Findings) -> Iterator[tuple[str, TimePlot, str]]:
    text = "Measured and simulated motor {} of {} over time, and the residual below: fit {} %"
    if f.extension is not None and f.extension.added:
        e = f.extension
        for name in (name for name in e.after if name in e.before):
            before, after = e.before[name], e.after[name]
            fits = f"{fixed(before.fit_percent)} % before and {fixed(after.fit_percent)}"
            yield (
                name,
                extended_plot(e, name, f.units),
                f"{text.format(e.output, name, fits)} after the extension."
                f"{given({name: e.events_of(name)}, f.units)}{_in_pieces(f)}",
            )
    elif f.validation is not None:
        best = f.validation.models[f.validation.best]
        for name, record in best.records.items():
            plot = trace_plot(name, record, best.output, f.units)
            events = left_in({name: f.events_of(name)})
            yield name, plot, f"{text.format(best.output, name, fixed(record.fit_percent))}.{events}"
