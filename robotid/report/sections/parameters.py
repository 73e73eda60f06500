"""The parameters of every model, and how their fits went."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from robotid.estimate.result import FitResult
from robotid.numerals import listed
from robotid.report.drawing.layout import intervals_figure, one_figure
from robotid.report.drawing.parameters import draw_iterations
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section


class Parameters(Section):
    """Values with intervals, and the iterations of the fits."""

    title = "Parameters"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """Intervals of all models, and their costs."""
        if f.fits is None:
            return
        fits = fitted(f)
        alt = f"Values of every parameter in {listed(list(fits))}, with intervals of two robust standard deviations."
        yield FigureSpec("parameters", "Parameters with intervals", alt, partial(intervals_figure, fits, f.units))
        alt = f"Cost of {listed(list(f.fits.models))} over the iterations of their fit."
        yield FigureSpec("iterations", "Iterations of the fits", alt, partial(one_figure, draw_iterations, f.fits))


def fitted(f: Findings) -> dict[str, FitResult]:
    """Every fit by the name of its model, the extended one last."""
    fits = {} if f.fits is None else dict(f.fits.models)
    if f.extension is not None and f.extension.added:
        fits[f"{f.extension.model} extended"] = f.extension.fit
    return fits
