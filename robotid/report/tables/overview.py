"""The axes of a robot side by side: how well the model of each simulates, and what it lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from robotid.numerals import fixed, listed
from robotid.report.findings import Findings
from robotid.report.tables.table import Table

VERDICTS = {"clean": "green", "named": "cyan", "partly named": "yellow", "unknown": "yellow", "not explained": "red"}


def overview(axes: Mapping[str, Findings]) -> Table:
    """A row an axis. The fits are those of the best model, in percent, over records from the lowest to the highest; the
    gain is what the extension adds to the fit of held-out records, in points. Of a robot with a body, the torque error
    that this leaves on held-out records stands beside them."""
    columns = ["axis", "model", "fit [%]", "held out [%]", "verdict", "causes", "held-out gain"]
    rows = {axis: [*_row(axis, f)] for axis, f in axes.items()}
    errors = {axis: _body_errors(axis, f) for axis, f in axes.items()}
    if any(errors.values()):
        columns.append("body: torque error, held out [%]")
        for axis, row in rows.items():
            row.append(_range(errors[axis], digits=1))
    return Table("Overview", tuple(columns), tuple(map(tuple, rows.values())), styles=VERDICTS)


def _row(axis: str, f: Findings) -> tuple[str, ...]:
    records = f.validation.models[f.validation.best].records.values() if f.validation is not None else ()
    fitted = [r.fit_percent for r in records if r.used]
    if f.validation is None and f.fits is not None:
        fitted = list(f.fits.models[f.fits.best].fit_percent.values())
    best = f.validation.best if f.validation is not None else f.fits.best if f.fits is not None else "-"
    verdict = f.diagnosis.verdict if f.diagnosis is not None else "-"
    causes = listed([cause.effect for cause in f.diagnosis.causes]) if f.diagnosis is not None else ""
    held_out = [r.fit_percent for r in records if not r.used]
    return axis, best, _range(fitted), _range(held_out), verdict, causes or "-", _range(_gains(f), sign="+")


def _body_errors(axis: str, f: Findings) -> list[float]:
    """Torque error [%] of the axis on each record that did not serve to identify the body."""
    body = None if f.recordings is None else f.recordings.body
    if body is None or axis not in body.axes:
        return []
    return [one.consistent[body.axes.index(axis)] for one in body.errors if not one.fitted]


def _gains(f: Findings) -> list[float]:
    """Of the fit of each held-out record."""
    if f.extension is None or not f.extension.added:
        return []
    before, after = f.extension.before, f.extension.after
    return [
        after[name].fit_percent - before[name].fit_percent for name in after if name in before and not after[name].used
    ]


def _range(values: Sequence[float], sign: str = "", digits: int = 2) -> str:
    if not values:
        return "-"
    ends = (min(values), max(values))
    low, high = (f"{'+' if sign and value > 0 else ''}{fixed(value, digits)}" for value in ends)
    return low if low == high else f"{low} to {high}"
