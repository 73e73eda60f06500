"""Runs side by side: what is known of each, as tables, JSON, a sentence and figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import isfinite

from robotid.display import Displayed
from robotid.estimate.comparison import Difference, FitComparison, WholeDifference, uncertainty
from robotid.estimate.result import FitResult
from robotid.model.units import on_axis
from robotid.numerals import fixed, listed, number, probability, resolved
from robotid.report.drawing.layout import has_two_columns, intervals_figure
from robotid.report.sections.section import FigureSpec
from robotid.report.tables.estimates import estimates_document, relative
from robotid.report.tables.table import Json, Table

MAX_NAMED = 4  # parameters that a sentence names


@dataclass(frozen=True, slots=True, eq=False)
class RunSummary:
    """What is known of one run. verdict, causes : of its diagnosis, empty where there is none; fit_percent : of its
    model on every record; gains : of its extension, fit before and after [%] by held-out record."""

    robot: str
    model: str
    fit_percent: Mapping[str, float]
    verdict: str = ""
    causes: tuple[str, ...] = ()
    gains: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RunComparison(Displayed):
    """Runs by name, and how their parameters compare. remarks : what makes the comparison doubtful."""

    runs: Mapping[str, RunSummary]
    fits: FitComparison
    remarks: tuple[str, ...] = ()

    @property
    def linear(self) -> bool:
        """Whether the axis slides, as the first run has it."""
        return next(iter(self.fits.fits.values())).structure.linear


def tables(found: RunComparison) -> tuple[Table, ...]:
    """Parameters, their differences, and what is known of each run."""
    return tuple(
        table for table in (_parameters(found), _differences(found), _runs(found), _gains(found)) if table.rows
    )


def document(found: RunComparison) -> Json:
    """The `compare --json` document of docs/command-line.md."""
    return {
        "runs": {name: _run_document(run, found.fits.fits[name]) for name, run in found.runs.items()},
        "reference": found.fits.reference,
        "level": found.fits.level,
        "differences": [_difference_document(d) for d in found.fits.differences],
        "together": [_whole_document(w) for w in found.fits.whole],
        "remarks": found.remarks,
    }


def sentence(found: RunComparison) -> str:
    """What differs, in words."""
    compared = found.fits
    changed = compared.changed
    if changed:
        named = [_in_words(compared, one) for one in changed[:MAX_NAMED]]
        more = f", and {len(changed) - MAX_NAMED} more" if len(changed) > MAX_NAMED else ""
        return f"{listed(named)}{more} differ{'s' if len(changed) == 1 else ''} from {compared.reference}"
    together = [one.run for one in compared.whole if one.differs]
    if together:
        are = "differs" if len(together) == 1 else "differ"
        return f"no parameter by itself, but all together, {listed(together)} {are} from {compared.reference}"
    return f"no parameter differs significantly from {compared.reference}"


def figures(found: RunComparison) -> Iterator[FigureSpec]:
    """Intervals of all runs."""
    fits = dict(found.fits.fits)
    alt = f"Values of every parameter in {listed(list(fits))}, with intervals of two robust standard deviations."
    units = on_axis(linear=found.linear)
    draw, wide = partial(intervals_figure, fits, units), has_two_columns(fits)
    yield FigureSpec("parameters", "Parameters with intervals", alt, draw, wide=wide)


def _in_words(compared: FitComparison, one: Difference) -> str:
    share = _relative(compared, one)
    by = f"{share} %" if share else f"{one.value:+.3g}"
    return f"{one.parameter} of {one.run} ({by})"


def _parameters(found: RunComparison) -> Table:
    fits = found.fits.fits
    units = {p.name: p.unit for fit in fits.values() for p in fit.parameters}
    columns = ("parameter", "unit", *(head for run in fits for head in (run, "+- 2 sd")))
    rows = tuple(
        (name, unit, *(cell for fit in fits.values() for cell in _cells(fit, name))) for name, unit in units.items()
    )
    return Table("Parameters", columns, rows, "two robust standard deviations either way")


def _cells(fit: FitResult, name: str) -> tuple[str, str]:
    p = next((p for p in fit.parameters if p.name == name), None)
    if p is None:
        return "", ""
    std = uncertainty(p)
    spread = "fixed" if p.fixed else number(2 * std, 2) if isfinite(std) else p.remark or "-"
    return resolved(p.value, 2 * std), spread


def _differences(found: RunComparison) -> Table:
    compared = found.fits
    columns = ("parameter", "run", "difference", "%", "sd", "p", "differs")
    rows = [
        (
            one.parameter,
            one.run,
            number(one.value),
            _relative(compared, one),
            number(one.std),
            probability(one.p_value),
            "yes" if one.differs else "no" if isfinite(one.p_value) else "not estimated",
        )
        for one in compared.differences
    ]
    rows += [
        ("all together", one.run, "", "", "", probability(one.p_value), "yes" if one.differs else "no")
        for one in compared.whole
        if one.degrees
    ]
    note = (
        f"differences from {compared.reference}; p corrected for the number of tests (Holm), differs below"
        f" {compared.level:g}"
    )
    return Table("Differences", columns, tuple(rows), "\n".join((note, *found.remarks)), {"yes": "yellow", "no": "dim"})


def _relative(compared: FitComparison, one: Difference) -> str:
    return relative(one.value, compared.fits[compared.reference][one.parameter].value)


def _runs(found: RunComparison) -> Table:
    columns = ("run", "robot", "model", "fit [%]", "verdict", "causes")
    rows = tuple(
        (name, r.robot, r.model, _range(r.fit_percent), r.verdict or "not diagnosed", ", ".join(r.causes))
        for name, r in found.runs.items()
    )
    return Table("Runs", columns, rows)


def _range(values: Mapping[str, float]) -> str:
    found = [fixed(value) for value in (min(values.values()), max(values.values()))] if values else ["-"]
    return " to ".join(dict.fromkeys(found))


def _gains(found: RunComparison) -> Table:
    rows = tuple(
        (run, record, fixed(before), fixed(after), fixed(after - before))
        for run, r in found.runs.items()
        for record, (before, after) in r.gains.items()
    )
    return Table("Gains of the extensions", ("run", "held-out record", "before [%]", "after [%]", "gain"), rows)


def _run_document(run: RunSummary, fit: FitResult) -> Json:
    return {
        "robot": run.robot,
        "model": run.model,
        "parameters": estimates_document(fit.parameters),
        "fit_percent": run.fit_percent,
        "verdict": run.verdict or None,
        "causes": run.causes,
        "gains": {record: {"before": before, "after": after} for record, (before, after) in run.gains.items()},
    }


def _difference_document(d: Difference) -> Json:
    return {
        "parameter": d.parameter,
        "run": d.run,
        "difference": d.value,
        "std": d.std,
        "p_value": d.p_value,
        "differs": d.differs,
    }


def _whole_document(w: WholeDifference) -> Json:
    return {
        "run": w.run,
        "chi2": w.statistic,
        "degrees": w.degrees,
        "p_value": w.p_value,
        "differs": w.differs,
    }
