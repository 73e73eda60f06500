"""What each parameter is worth."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from robotid.report.drawing.layout import perturbation_figure
from robotid.report.drawing.perturbation import perturbations
from robotid.report.events import left_in
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section


class PerturbedParameters(Section):
    """Table 3 of the paper: the change of the fit when a parameter is changed."""

    title = "What each parameter is worth"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """The heat map."""
        if f.validation is None:
            return
        best = f.validation.models[f.validation.best]
        if found := perturbations(best):
            alt = f"Change of the fit of {f.validation.best} when one parameter at a time is raised or lowered"
            alt = f"{alt}, held-out records first.{left_in({name: f.events_of(name) for name in found})}"
            draw = partial(perturbation_figure, best)
            yield FigureSpec("perturbation", "Change of the fit", alt, draw, wide=len(found) > 2)
