"""What is left in the residual of the best model."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from robotid.report.drawing.layout import correlation_figure, one_figure
from robotid.report.drawing.residual import draw_spectra
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section


class Residuals(Section):
    """Spectrum and correlations of the residual of each record."""

    title = "What is left in the residual"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """Of each record."""
        for name, spectra in f.evidence.spectra.items():
            extended = "before and after the extension, " if spectra.after is not None else ""
            alt = f"What the model leaves of {name} over frequency, {extended}beside the noise floor."
            draw = partial(one_figure, draw_spectra, name, spectra, f.unit_of_output)
            yield FigureSpec(f"spectrum-{name}", f"Residual of {name} over frequency", alt, draw)
        if f.validation is None:
            return
        best = f.validation.models[f.validation.best]
        for name, record in best.records.items():
            alt = f"Correlations of the residual of {name} in {f.validation.best} with itself and with the torque"
            alt = f"{alt}, and the bands that all of them keep to at 99 %. Verdict: {record.residual.verdict}."
            draw = partial(correlation_figure, name, best)
            yield FigureSpec(f"correlations-{name}", name, alt, draw)
