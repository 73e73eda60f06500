"""A watched model as tables and JSON."""

from __future__ import annotations

from robotid.monitoring import ParameterShift, WatchedLog, WatchResult
from robotid.numerals import fixed, listed, number, plain, probability
from robotid.report.tables.estimates import relative
from robotid.report.tables.table import Json, Table

STATES = {"unchanged": "green", "changed": "yellow", "not explained": "red"}


def tables(found: WatchResult) -> tuple[Table, ...]:
    """A row a log, and what has changed."""
    columns = ("log", "state", "p", "fit [%]", "usual [%]", "residual", "p parameters", "p residual")
    rows = tuple(
        (
            one.record,
            one.state,
            probability(one.p_value),
            fixed(one.fit_percent),
            fixed(one.usual_percent),
            number(one.residual_ratio, 3),
            probability(one.p_parameters),
            probability(one.p_residual),
        )
        for one in found.logs
    )
    note = (
        f"residual: energy over that on {listed(list(found.records))}, the records of the fit;"
        f" an alarm below p = {found.level:g}"
    )
    main = Table(f"Model {found.model} on new logs", columns, rows, "\n".join((note, *found.remarks)), STATES)
    changes = _changes(found)
    return (main, changes) if changes.rows else (main,)


def _changes(found: WatchResult) -> Table:
    columns = ("log", "parameter", "unit", "before", "change", "%", "sd", "or as well")
    rows = tuple(
        (
            log.record,
            one.parameter,
            one.unit,
            number(one.before),
            number(one.shift),
            relative(one.shift, one.before),
            number(one.std),
            ", ".join(twin for twin in log.twins if twin != one.parameter),
        )
        for log in found.logs
        if (one := log.change) is not None
    )
    return Table("What has changed", columns, rows)


def document(found: WatchResult) -> Json:
    """The `watch --json` document of docs/command-line.md."""
    return {
        "model": found.model,
        "records": found.records,
        "level": found.level,
        "alarm": found.alarm,
        "logs": {one.record: _log(one) for one in found.logs},
        "remarks": found.remarks,
    }


def sentence(found: WatchResult) -> str:
    """The verdict in words."""
    if not found.alarm:
        return f"{found.model} is still right"
    return "; ".join(_alarm(one) for one in found.logs if one.state != "unchanged")


def _alarm(one: WatchedLog) -> str:
    if one.state == "not explained":
        return f"{one.record}: the model is no longer right, and no change of a parameter explains it"
    if one.change is None:
        return f"{one.record}: several parameters have changed"
    change, unit = one.change, f" {one.change.unit}" if one.change.unit not in ("", "1") else ""
    others = [twin for twin in one.twins if twin != change.parameter]
    doubt = f" (or {listed(others, 'or')})" if others else ""
    return f"{one.record}: {change.parameter} has changed by {plain(change.shift)}{unit}{doubt}"


def _log(one: WatchedLog) -> Json:
    return {
        "state": one.state,
        "p_value": one.p_value,
        "p_parameters": one.p_parameters,
        "p_residual": one.p_residual,
        "fit_percent": one.fit_percent,
        "usual_percent": one.usual_percent,
        "residual_ratio": one.residual_ratio,
        "change": None if one.change is None else _change(one.change),
        "twins": one.twins,
    }


def _change(one: ParameterShift) -> Json:
    return {
        "parameter": one.parameter,
        "unit": one.unit,
        "before": one.before,
        "change": one.shift,
        "std": one.std,
    }
