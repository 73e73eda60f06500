"""The axes of a robot side by side: how well the model of each simulates, and what it lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from robotid.numerals import fixed, listed
from robotid.report.findings import Findings
from robotid.report.tables.table import Table

VERDICTS = {"clean": "green", "named": "cyan", "partly named": "yellow", "unknown": "yellow", "not explained": "red"}


def overview(axes: Mapping[str, Findings]) -> Table:
    """A row an axis. The fits are those of the best model, in percent, over records from the lowest to the highest; the
    gain is what the extension adds to the fit of held-out records, in points."""
    columns = ("axis", "model", "fit [%]", "held out [%]", "verdict", "causes", "held-out gain")
    return Table("Overview", columns, tuple(_row(axis, f) for axis, f in axes.items()), styles=VERDICTS)


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


def _gains(f: Findings) -> list[float]:
    """Of the fit of each held-out record."""
    if f.extension is None or not f.extension.added:
        return []
    before, after = f.extension.before, f.extension.after
    return [
        after[name].fit_percent - before[name].fit_percent for name in after if name in before and not after[name].used
    ]


def _range(values: Sequence[float], sign: str = "") -> str:
    if not values:
        return "-"
    low, high = (f"{'+' if sign and value > 0 else ''}{fixed(value)}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"
