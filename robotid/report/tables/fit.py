"""The fitted models as tables and JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from typing import TYPE_CHECKING

from robotid.estimate.result import Estimate, FitResult, Fits
from robotid.numerals import fixed, listed, number
from robotid.report.tables.estimates import estimate_document
from robotid.report.tables.table import Json, Table

if TYPE_CHECKING:
    from robotid.report.evidence.profile import ProfileInterval, Profiles

NOTE = "sd: standard deviation that allows for coloured residuals"
PROFILE_NOTE = "profile interval: how far a doubtful parameter may go, all others refitted, as two sd would allow"


def tables(fits: Fits) -> tuple[Table, ...]:
    """Parameters, fit per record, and how each model's fit ended."""
    several = (_parameters(fits),) if len(fits.models) > 1 else ()
    return (*several, parameter_table(fits.best, fits.models[fits.best], {}), _fit_percent(fits), _ends(fits))


def parameter_table(name: str, fit: FitResult, starts: Mapping[str, float], profiles: Profiles | None = None) -> Table:
    """A row a parameter of one model: how well it is known, where its fit started, and how far it may go. profiles : of
    its doubtful parameters; the note says which have none, and why."""
    intervals = {} if profiles is None else profiles.intervals
    bounds = ("start", "lower bound", "upper bound")
    columns = ("parameter", "unit", "value", "sd", "sd [%]", "profile interval", *bounds, "remark")
    rows = tuple(_precisely(p, starts, intervals.get(p.name)) for p in fit.parameters)
    note = (NOTE, *[PROFILE_NOTE] * bool(intervals), *_without(profiles))
    return Table(f"Parameters of {name}", columns, rows, "\n".join(note))


def _without(profiles: Profiles | None) -> Iterator[str]:
    """Why doubtful parameters have no profile interval, in a sentence a reason."""
    without = {} if profiles is None else profiles.without
    for why in dict.fromkeys(without.values()):
        yield f"no profile interval of {listed([name for name, own in without.items() if own == why], 'or')}: {why}"


def _precisely(p: Estimate, starts: Mapping[str, float], profile: ProfileInterval | None) -> tuple[str, ...]:
    share = relative_std(p)
    unlike = "" if profile is None or profile.symmetric else "its interval is not symmetric"
    return (
        p.name,
        p.unit,
        number(p.value, 5),
        number(p.std_robust, 2),
        "-" if share is None else fixed(100 * share, 2 if share < 0.1 else 0),
        "" if profile is None else f"{number(profile.lower, 3)} to {number(profile.upper, 3)}",
        number(starts[p.name], 5) if p.name in starts else "",
        "" if p.fixed else number(p.lower, 3),
        "" if p.fixed else number(p.upper, 3),
        "; ".join(filter(None, (p.remark, unlike))),
    )


def relative_std(p: Estimate) -> float | None:
    """Robust standard deviation over the value, None where there is none or the value is zero."""
    return p.std_robust / abs(p.value) if isfinite(p.std_robust) and p.value and not p.fixed else None


def document(fits: Fits) -> Json:
    """The `fit --json` document of docs/command-line.md."""
    return {"models": {name: _model(fit) for name, fit in fits.models.items()}, "best": fits.best}


def sentence(fits: Fits) -> str:
    """What makes the fit that later stages use doubtful, if anything does: the first remark and the last, which is what
    would cure it."""
    remarks = fits.models[fits.best].remarks
    return f"{fits.best}: {'; '.join(dict.fromkeys([remarks[0], remarks[-1]]))}" if remarks else ""


def _model(fit: FitResult) -> Json:
    return {
        "parameters": {p.name: _estimate(p) for p in fit.parameters},
        "records": fit.records,
        "output": fit.output,
        "iterations": fit.iterations,
        "converged": fit.converged,
        "end": fit.end.value,
        "seconds": fit.seconds,
        "fit_percent": fit.fit_percent,
        "remarks": fit.remarks,
    }


def _estimate(p: Estimate) -> Json:
    return estimate_document(p) | ({"remark": p.remark} if p.remark else {})


def _parameters(fits: Fits) -> Table:
    """A row a parameter; for each model its value and residual-robust standard deviation."""
    units = {p.name: p.unit for fit in fits.models.values() for p in fit.parameters}
    columns = ("parameter", "unit", *(head for name in fits.models for head in (name, "sd")), "remark")
    rows = []
    for name, unit in units.items():
        cells, remarks = [], []
        for model, fit in fits.models.items():
            p = next((p for p in fit.parameters if p.name == name), None)
            cells += [number(p.value, 5), number(p.std_robust, 2)] if p else ["-", "-"]
            remarks += [f"{model}: {p.remark}"] if p and p.remark else []
        rows.append((name, unit, *cells, "; ".join(remarks)))
    return Table("Parameters", columns, tuple(rows), NOTE)


def _fit_percent(fits: Fits) -> Table:
    names = dict.fromkeys(name for fit in fits.models.values() for name in fit.fit_percent)
    rows = tuple((name, *_cells(fits.models.values(), name)) for name in names)
    return Table("Fit [%]", ("record", *fits.models), rows)


def _cells(models: Iterable[FitResult], record: str) -> list[str]:
    return [fixed(fit.fit_percent.get(record)) for fit in models]


def _ends(fits: Fits) -> Table:
    rows = tuple(
        (name, ", ".join(fit.records), str(fit.iterations), fixed(fit.seconds), fit.end.value)
        for name, fit in fits.models.items()
    )
    remarks = [f"{name}: {remark}" for name, fit in fits.models.items() for remark in fit.remarks]
    note = "\n".join((*remarks, f"later stages use {fits.best}"))
    return Table("Fits", ("model", "records", "iterations", "seconds", "end"), rows, note)
