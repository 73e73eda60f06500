"""The records themselves, or before there are any the references for them."""

from __future__ import annotations

from collections.abc import Iterator

from robotid.numerals import listed
from robotid.report.drawing.time import record_plot, reference_plot
from robotid.report.findings import Findings
from robotid.report.sections.section import FigureSpec, Section, over_time
from robotid.report.style.axes import axis_label


class Records(Section):
    """Torque and speed of every record."""

    title = "Records"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """One of each record."""
        for record in f.recordings.records if f.recordings is not None else ():
            angles = ["motor angle", *["arm angle"] * (record.phi_a is not None)]
            shown = [axis_label(one, f.units) for one in ("Motor torque", "motor speed", *angles)]
            alt = f"{listed(shown)} of {record.name} over time."
            yield over_time(f"record-{record.name}", record_plot(record, f.units), alt, record.name, len(record))


class References(Section):
    """What the controller is to follow, until it is recorded."""

    title = "References"

    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """One of each reference."""
        if f.recordings is not None or f.excitation is None:
            return
        for reference in f.excitation.references:
            alt = f"Reference of {reference.name} over time."
            yield over_time(f"reference-{reference.name}", reference_plot(reference, f.units), alt, reference.name)
