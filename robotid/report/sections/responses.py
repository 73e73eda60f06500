"""Frequency responses, measured and of the models."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from robotid.numerals import listed
from robotid.report.drawing.frequency import Motion, Responses
from robotid.report.drawing.layout import responses_figure
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section
from robotid.report.style.axes import axis_label


class FrequencyResponses(Section):
    """Measured responses, beside those of the models where there are any."""

    title = "Frequency responses"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """The responses to torque, of speed and of acceleration where a model stands beside them."""
        if not f.frfs:
            return
        shown = Responses(f.frfs, f.evidence.responses, f.evidence.coherences)
        if not shown.models:
            draw = partial(responses_figure, shown, "acceleration", f.units)
            yield FigureSpec("responses", "Measured responses", _alt(shown, "acceleration"), draw)
            return
        motions: tuple[Motion, ...] = ("speed", "acceleration")
        for motion in motions:
            draw = partial(responses_figure, shown, motion, f.units)
            alt = axis_label(_alt(shown, motion), f.units)
            yield FigureSpec(f"bode-{motion}", f"Model and measured responses, {motion}", alt, draw)


def _alt(shown: Responses, motion: Motion) -> str:
    what = "Magnitude (left in SI, right in dB), phase" + (" and coherence" if shown.coherences else "")
    linear = [name for name, model in shown.models.items() if not model.simulated]
    others = [name for name, model in shown.models.items() if model.simulated]
    models = f"; lines are {listed(linear)}, linearised about rest" if linear else ""
    models += f", and {listed(others)} as simulated on these records" if others else ""
    averages = {one.averages for one in shown.coherences.values()}
    over = f" The coherence is over {listed([str(n) for n in sorted(averages)])} stretches." if averages else ""
    return (
        f"{what} from motor torque to motor {motion}: dots are the measured responses of"
        f" {listed([frf.record for frf in shown.measured])} with bars of two standard deviations{models}.{over}"
    )
