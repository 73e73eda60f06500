"""The fitted models as tables and JSON."""

from __future__ import annotations

from collections.abc import Iterable

from robotid.estimate.result import Estimate, FitResult, Fits
from robotid.numerals import fixed, number
from robotid.report.tables.table import Json, Table


def tables(fits: Fits) -> tuple[Table, ...]:
    """Parameters, fit per record, and how each model's fit ended."""
    return _parameters(fits), _fit_percent(fits), _ends(fits)


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
    shown: dict[str, Json] = {"value": p.value, "std": p.std, "std_robust": p.std_robust, "unit": p.unit}
    return shown | ({"remark": p.remark} if p.remark else {})


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
    return Table("Parameters", columns, tuple(rows), "sd: standard deviation that allows for coloured residuals")


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
