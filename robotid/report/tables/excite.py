"""The references as tables and JSON."""

from __future__ import annotations

import numpy as np

from robotid.numerals import number
from robotid.report.tables.table import Json, Table
from robotid.signals.reference import Excitation, Reference


def tables(excitation: Excitation) -> tuple[Table, ...]:
    """One row a reference."""
    if not excitation.references:
        return (Table("References", ("",), (), "every record is measured: there is nothing to excite"),)
    columns = ("reference", "of", "samples", "sampling time [s]", "period [s]", "band [Hz]", "peak", "crest factor")
    return (Table("References", columns, tuple(map(_row, excitation.references))),)


def document(excitation: Excitation) -> Json:
    """The `excite --json` document."""
    return {"references": {r.name: _entry(r) for r in excitation.references}}


def _row(r: Reference) -> tuple[str, ...]:
    band = "-" if r.band is None else f"{r.band[0]:g} to {r.band[1]:g}"
    crest, period = number(r.crest_factor), number(r.period)
    return r.name, r.kind, str(len(r)), f"{r.sampling_time:g}", period, band, number(_peak(r)), crest


def _entry(r: Reference) -> Json:
    return {
        "quantity": r.kind,
        "samples": len(r),
        "sampling_time": r.sampling_time,
        "period": r.period,
        "band": r.band,
        "peak": _peak(r),
        "crest_factor": r.crest_factor,
    }


def _peak(r: Reference) -> float:
    return float(np.abs(r.ref).max())
