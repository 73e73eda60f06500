"""The parameters of every model, and how their fits went."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

from robotid.estimate.result import FitResult
from robotid.numerals import listed
from robotid.report.drawing.correlation import draw_correlation, estimated
from robotid.report.drawing.layout import has_two_columns, intervals_figure, matrix_figure, one_figure
from robotid.report.drawing.parameters import draw_iterations
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section, slug
from robotid.report.tables.fit import parameter_table
from robotid.report.tables.table import Table


class Parameters(Section):
    """Values with intervals, how they hang together, and the iterations of the fits."""

    title = "Parameters"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """Intervals of all models, correlations of the best and of its extension, and their costs."""
        if f.fits is None:
            return
        fits = fitted(f)
        alt = f"Values of every parameter in {listed(list(fits))}, with intervals of two robust standard deviations."
        extension = f.extension_that_adds
        draw = partial(intervals_figure, fits, f.units, None if extension is None else extension.model)
        wide = has_two_columns(fits)
        yield FigureSpec("parameters", "Parameters with intervals", alt, draw, wide=wide)
        shown = {name: fit for name, fit in fits.items() if len(estimated(fit)) > 1}
        chosen = [name for name in (f.fits.best, *list(fits)[len(f.fits.models) :]) if name in shown]
        for name in chosen:
            fit = shown[name]
            alt = (
                f"Correlation of the estimates of {name}: pairs near +1 or −1 cannot be distinguished by these records."
            )
            draw = partial(matrix_figure, draw_correlation, len(estimated(fit)), name, fit)
            yield FigureSpec(f"correlation-of-{slug(name)}", f"Correlation of the estimates of {name}", alt, draw)
        ends = listed([f"{name}: {one.end.value}" for name, one in f.fits.models.items()])
        whose = "their fits" if len(f.fits.models) > 1 else "its fit"
        alt = f"Cost of {listed(list(f.fits.models))} over the iterations of {whose}. How it ended: {ends}."
        draw = partial(one_figure, draw_iterations, f.fits)
        paired = (len(chosen) + (not wide)) % 2 == 0
        yield FigureSpec("iterations", "Iterations of the fits", alt, draw, folded=paired)

    def tables(self, f: Findings) -> Iterator[Table]:
        """Every parameter with its precision, its start and its bounds, of the best model and of its extension."""
        if f.fits is not None:
            best, profiles = f.fits.best, f.evidence.profiles
            yield parameter_table(best, f.fits.models[best], _starts(f), profiles.get(best))
        if (extension := f.extension_that_adds) is not None:
            starts = f.diagnosis.refitted if f.diagnosis is not None else {}
            name = f"{extension.model} extended"
            yield parameter_table(name, extension.fit, starts, f.evidence.profiles.get(name))


def _starts(f: Findings) -> Mapping[str, float]:
    """Where the fits started, as far as that is known."""
    if f.validation is None:
        return {}
    first = next(iter(f.validation.models.values()))
    return dict(zip(first.names, first.values.tolist(), strict=True))


def fitted(f: Findings) -> dict[str, FitResult]:
    """Every fit by the name of its model, the extended one last."""
    fits = {} if f.fits is None else dict(f.fits.models)
    if f.extension is not None and f.extension.added:
        fits[f"{f.extension.model} extended"] = f.extension.fit
    return fits
