"""What is left in the residual of the best model."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from robotid.report.drawing.layout import correlation_figure
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section


class Residuals(Section):
    """Correlations of the residual of each record."""

    title = "What is left in the residual"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """One of each record."""
        if f.validation is None:
            return
        best = f.validation.models[f.validation.best]
        for name, record in best.records.items():
            alt = f"Correlations of the residual of {name} with itself and with the torque, with bands at 99 %."
            alt = f"{alt} Verdict: {record.residual.verdict}."
            draw = partial(correlation_figure, name, best)
            yield FigureSpec(f"correlations-{name}", name, alt, draw)
