"""The causes of the misfit, and what the extension by them gained."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import isfinite

from robotid.diagnosis.results import Cause
from robotid.numerals import fixed, listed, portion
from robotid.report.drawing.causes import rows_of
from robotid.report.drawing.gain import gains
from robotid.report.drawing.layout import causes_figure, gain_figure
from robotid.report.events import given
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section


class Causes(Section):
    """The ranking of causes, and the fit before and after the extension."""

    title = "Causes and gain"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """The ranking and the gain, where there are any."""
        yield from _causes(f)
        yield from _gain(f)


def _causes(f: Findings) -> Iterator[FigureSpec]:
    if f.diagnosis is not None and rows_of(f.diagnosis):
        causes = listed([_explains(cause) for cause in f.diagnosis.causes])
        alt = f"Effects ranked by the share of the misfit that they explain: {causes or 'none is a cause'}."
        if any(isfinite(cause.heldout_gain) for cause in f.diagnosis.causes):
            alt += " Beside its share stands what a cause gains on held-out records [% points]."
        alt += " Grey ones were rejected, for the reasons in the table of the diagnosis." * bool(f.diagnosis.rejected)
        draw = partial(causes_figure, f.diagnosis)
        yield FigureSpec("causes", "Causes, ranked", alt, draw, folded=not f.diagnosis.causes)


def _explains(cause: Cause) -> str:
    of = f" of {cause.explained_of}" if cause.explained_of else ""
    return f"{cause.effect} explains {portion(cause.explained)}{of}"


def _gain(f: Findings) -> Iterator[FigureSpec]:
    if f.extension is not None and f.extension.added:
        pairs = gains(f.extension, used=True) | gains(f.extension, used=False)
        text = listed([f"{name} from {fixed(a)} to {fixed(b)} %" for name, (a, b) in pairs.items()])
        alt = f"Fit before and after the extension by record, held-out records apart: {text}."
        alt += given({name: f.extension.events_of(name) for name in pairs}, f.units)
        yield FigureSpec("gain", "Fit before and after the extension", alt, partial(gain_figure, f.extension))
