"""The validation as tables and JSON: Tables 1 to 3 of the paper, and what they leave open."""

from __future__ import annotations

from math import sqrt

from robotid.model.units import unit_of
from robotid.numerals import fixed, number, rms
from robotid.report.tables.table import Json, Table
from robotid.validation.results import ModelValidation, Perturbation, RecordValidation, Validation

FIT_NOTE = "100 %: no error, 0 %: an error as large as the signal's deviation from its mean; *: fitted to this record"


def tables(validation: Validation) -> tuple[Table, ...]:
    """Parameters and fit of every model, and of the best one all the rest."""
    best, name = validation.models[validation.best], validation.best
    return (
        _parameters(validation),
        _fit_percent(validation),
        _errors(name, best),
        *_closed_loop(name, best),
        *_perturbation(name, best),
        *_identifiability(name, best),
        _residuals(name, best),
        *_failed(validation),
    )


def document(validation: Validation) -> Json:
    """The `validate --json` document of docs/command-line.md."""
    models: dict[str, Json] = {name: _model(model) for name, model in validation.models.items()}
    return {"models": models, "best": validation.best, "failed": validation.failed}


def _model(model: ModelValidation) -> Json:
    return {
        "records": {name: _record(record) for name, record in model.records.items()},
        "perturbation": {name: _changes(p) for name, p in _perturbations(model).items()},
        "identifiability": {i.name: {"verdict": i.verdict, "why": i.why} for i in model.identifiability},
        "bode_distance_db": model.bode.distance if model.bode is not None else {},
        "remarks": model.remarks,
    }


def _record(record: RecordValidation) -> Json:
    loop, residual = record.closed_loop, record.residual
    return {
        "role": record.role,
        "used": record.used,
        "fit_percent": record.fit_percent,
        "rmse": {"speed": record.rmse_speed, "position": record.rmse_position},
        "torque_error_percent": record.torque_error_percent,
        "closed_loop": None
        if loop is None
        else {
            "position_percent": loop.position_percent,
            "speed_percent": loop.speed_percent,
            "torque_percent": loop.torque_percent,
            "rmse": {"position": loop.position_rmse, "speed": loop.speed_rmse, "torque": loop.torque_rmse},
        },
        "residual": {
            "whiteness_p": residual.whiteness_p,
            "independence_p": residual.independence_p,
            "white_part": residual.white_part,
            "coloured_part": residual.coloured_part,
        },
        "remarks": record.remarks,
    }


def _perturbations(model: ModelValidation) -> dict[str, Perturbation]:
    return {name: r.perturbation for name, r in model.records.items()}


def _changes(p: Perturbation) -> Json:
    changes = zip(p.names, p.plus.tolist(), p.minus.tolist(), strict=True)
    return {name: {"percent": p.percent, "plus": plus, "minus": minus} for name, plus, minus in changes}


def _parameters(validation: Validation) -> Table:
    """Table 1: a row a parameter, a column a model, and the standard deviation of the best model."""
    models, best = validation.models, validation.models[validation.best]
    std = [sqrt(v) if v > 0 else float("nan") for v in best.covariance.diagonal().tolist()] or [float("nan")] * len(
        best.names
    )
    rows = tuple(
        (name, unit, *(_value(model, name) for model in models.values()), number(std[k], 2))
        for k, (name, unit) in enumerate(zip(best.names, best.units, strict=True))
    )
    columns = ("parameter", "unit", *models, f"sd of {validation.best}")
    return Table("Parameters", columns, rows, "the first model is where the fits started")


def _value(model: ModelValidation, name: str) -> str:
    return number(float(model.values[model.names.index(name)]), 5) if name in model.names else "-"


def _fit_percent(validation: Validation) -> Table:
    """Table 2: a row a record, a column a model; a star where the model was fitted to the record."""
    names = dict.fromkeys(name for model in validation.models.values() for name in model.records)
    rows = tuple((name, *(_fit(model, name) for model in validation.models.values())) for name in names)
    return Table(
        "Fit [%]",
        ("record", *validation.models),
        rows,
        FIT_NOTE,
    )


def _fit(model: ModelValidation, name: str) -> str:
    record = model.records.get(name)
    return "-" if record is None else fixed(record.fit_percent) + ("*" if record.used else " ")


def _errors(name: str, model: ModelValidation) -> Table:
    rows = tuple(
        (
            record,
            r.role,
            rms(r.rmse_speed, 4),
            rms(r.rmse_position, 4),
            fixed(r.torque_error_percent),
            "; ".join(r.remarks),
        )
        for record, r in model.records.items()
    )
    columns = ("record", "role", "RMSE speed", "RMSE position", "torque error [%]", "remark")
    return Table(f"Errors of {name} in open loop, SI", columns, rows, "\n".join(model.remarks))


def _closed_loop(name: str, model: ModelValidation) -> tuple[Table, ...]:
    rows = tuple(
        (
            record,
            fixed(r.closed_loop.position_percent, 4),
            fixed(r.closed_loop.speed_percent, 3),
            fixed(r.closed_loop.torque_percent),
        )
        for record, r in model.records.items()
        if r.closed_loop is not None
    )
    columns = ("record", "position", "speed", "torque")
    return (Table(f"Errors of {name} in closed loop [%]", columns, rows),) if rows else ()


def _perturbation(name: str, model: ModelValidation) -> tuple[Table, ...]:
    """Table 3: a row a parameter, the change of the fit of each record."""
    found = _perturbations(model)
    if not found:
        return ()
    first = next(iter(found.values()))
    rows = tuple(
        (parameter, *(f"{fixed(p.plus[k])} / {fixed(p.minus[k])}" for p in found.values()))
        for k, parameter in enumerate(first.names)
    )
    title = f"Change of the fit of {name} for +{first.percent:g} % / −{first.percent:g} %"
    return (Table(title, ("parameter", *found), rows),)


def _identifiability(name: str, model: ModelValidation) -> tuple[Table, ...]:
    rows = tuple((i.name, i.verdict, i.why) for i in model.identifiability)
    return (Table(f"What the records of {name} can see", ("parameter", "verdict", "why"), rows),) if rows else ()


def _residuals(name: str, model: ModelValidation) -> Table:
    rows = tuple(
        (
            record,
            rms(r.residual.white_part, 3),
            rms(r.residual.coloured_part, 3),
            _p(r.residual.whiteness_p),
            _p(r.residual.independence_p),
        )
        for record, r in model.records.items()
    )
    unit = unit_of(model.output, linear=model.structure.linear)
    columns = ("record", f"white part [{unit}]", f"coloured part [{unit}]", "p white", "p independent of torque")
    note = "p below 0.01: a pattern is left; the coloured part tells how large it is"
    return Table(f"Residuals of {name}", columns, rows, note)


def _p(value: float) -> str:
    return "<0.001" if value < 0.001 else fixed(value, 3)


def _failed(validation: Validation) -> tuple[Table, ...]:
    rows = tuple((sentence,) for sentence in validation.failed)
    return (Table("Below the threshold", ("",), rows),) if rows else ()


def sentence(validation: Validation) -> str:
    """How well the best model simulates what it was fitted to, and what it was not."""
    records = validation.models[validation.best].records.items()
    groups = {"": [r for r in records if r[1].used], " and, held out, ": [r for r in records if not r[1].used]}
    parts = [
        joint + ", ".join(f"{name} to {fixed(record.fit_percent)} %" for name, record in group)
        for joint, group in groups.items()
        if group
    ]
    return f"{validation.best} simulates {''.join(parts).removeprefix(' and, ')}" if parts else ""
