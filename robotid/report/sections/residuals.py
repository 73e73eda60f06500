"""What is left in the residual of the best model."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from robotid.numerals import number
from robotid.report.drawing.layout import correlation_figure, one_figure
from robotid.report.drawing.residual import draw_spectra
from robotid.report.events import given, left_in
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section
from robotid.report.style.axes import axis_label
from robotid.validation.results import ModelValidation, ResidualTest


class Residuals(Section):
    """Spectrum and correlations of the residual of each record."""

    title = "What is left in the residual"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """Of each record, its spectrum beside its correlations."""
        best = None if f.validation is None else f.validation.models[f.validation.best]
        for name in dict.fromkeys((*f.evidence.spectra, *(best.records if best else ()))):
            if name in f.evidence.spectra:
                yield _spectrum(f, name)
            if best is not None and name in best.records:
                yield _correlations(f, best, name)


def _spectrum(f: Findings, name: str) -> FigureSpec:
    """What the model leaves of a record over frequency."""
    spectra = f.evidence.spectra[name]
    e = f.extension_that_adds
    extended = "before and after the extension, " if spectra.after is not None else ""
    alt = f"What the model leaves of {name} over frequency, {extended}beside the noise floor."
    alt += left_in({name: f.events_of(name)}) if e is None else given({name: e.events_of(name)}, f.units)
    draw = partial(one_figure, draw_spectra, name, spectra, f.unit_of_output)
    return FigureSpec(f"spectrum-{name}", f"Residual of {name} over frequency", alt, draw)


def _correlations(f: Findings, model: ModelValidation, name: str) -> FigureSpec:
    """What the residual of a record has to do with itself and with the torque."""
    test, of = model.records[name].residual, "" if f.validation is None else f.validation.best
    alt = f"Correlations of the residual of {name} in {of} with itself and with the torque, and the bands that all of"
    alt = f"{alt} them keep to at 99 %. Verdict: {test.verdict}{_though_clean(f, name, test)}."
    alt += left_in({name: f.events_of(name)})
    draw = partial(correlation_figure, name, model, f.units)
    return FigureSpec(f"correlations-{name}", name, axis_label(alt, f.units), draw)


def _though_clean(f: Findings, name: str, test: ResidualTest) -> str:
    """How little of a clean record it is that follows the torque."""
    if test.independent or not f.is_clean(name):
        return ""
    counted = test.crosscorrelation[len(test.crosscorrelation) // 2 + 1 :]
    share = number(100 * float(np.max(counted**2)), 2)
    return f", {share} % of the residual's energy at most, which is within the noise floor of the diagnosis"
