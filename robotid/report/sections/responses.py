"""Frequency responses, measured and of the models."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from robotid.numerals import listed
from robotid.report.drawing.frequency import bode_models, draw_bode
from robotid.report.drawing.layout import one_figure, responses_figure
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section


class Responses(Section):
    """Measured responses, beside those of the models where there are any."""

    title = "Frequency responses"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """The responses to torque, of speed and of acceleration where a model stands beside them."""
        frfs = f.flex.frfs if f.flex is not None else ()
        models = {} if f.validation is None else bode_models(f.validation)
        validated = f.validation if f.validation is not None and f.validation.frfs and models else None
        if frfs and validated is None:
            names = listed([frf.record for frf in frfs])
            alt = (
                f"Magnitude of the measured responses of {names} from motor torque to motor acceleration against"
                " frequency, with bands of two standard deviations."
            )
            yield FigureSpec("responses", "Measured responses", alt, partial(responses_figure, frfs, f.units))
        if validated is not None:
            for motion in ("speed", "acceleration"):
                alt = (
                    f"Bode magnitude of {listed(list(models))}, linearised, from motor torque to motor {motion}, beside"
                    " the measured responses with bands of two standard deviations."
                )
                draw = partial(one_figure, draw_bode, validated.frfs, models, motion, f.units)
                yield FigureSpec(f"bode-{motion}", f"Model and measured responses, {motion}", alt, draw)
