"""The diagnosis as tables and JSON: how much is wrong, where, why, and what the data cannot tell from the cause."""

from __future__ import annotations

import json

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.results import Cause, Diagnosis, Rejected, Separation
from robotid.estimate.result import Estimate
from robotid.model.units import sliding
from robotid.numerals import fixed, number, percent, rms
from robotid.report.tables.table import Json, Table

SHOWN = 12  # bins of a shape that a table shows
VERDICTS = {"clean": "green", "named": "cyan", "unknown": "yellow", "not explained": "red"}


def tables(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """The verdict with the misfit of each record, where it sits, its causes, and what was rejected."""
    return (
        _verdict(diagnosis),
        _records(diagnosis),
        *_curves(diagnosis),
        *_causes(diagnosis),
        *_separations(diagnosis),
        *_rejected(diagnosis),
        *_shape(diagnosis),
    )


def brief(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """The verdict and its causes alone."""
    return (_verdict(diagnosis), *_causes(diagnosis), *_separations(diagnosis), *_shape(diagnosis))


def document(diagnosis: Diagnosis) -> Json:
    """The `diagnose --json` document of docs/command-line.md."""
    torque = "Nm" if diagnosis.unit != sliding(diagnosis.unit) else "N"
    return {
        "verdict": diagnosis.verdict,
        "model": diagnosis.model,
        "noise_floor": diagnosis.noise_floor,
        "misfit": diagnosis.misfit,
        "unit": diagnosis.unit,
        "causes": [_cause(cause) for cause in diagnosis.causes],
        "rejected": [rejected_document(one) for one in diagnosis.rejected],
        "remaining": diagnosis.remaining,
        "shape": None if diagnosis.shape is None else _curve(diagnosis.shape, torque),
        "records": {
            name: {
                "role": m.role,
                "fit_percent": m.fit_percent,
                "rmse": m.rmse,
                "noise_floor": m.noise_floor,
                "misfit": m.misfit,
                "explained_after": m.explained_after,
            }
            for name, m in diagnosis.records.items()
        },
        "where": [_curve(curve, torque) for curve in diagnosis.curves],
        "remarks": diagnosis.remarks,
    }


def sentence(diagnosis: Diagnosis) -> str:
    """The verdict."""
    d, unit = diagnosis, diagnosis.unit
    if d.verdict == "clean":
        return f"{d.model} leaves nothing to explain beyond the noise of {rms(d.noise_floor, 2)} {unit}"
    if d.verdict == "not explained":
        wrong = f"it is wrong by {rms(d.misfit, 2)} {unit}"
        return f"{d.model} does not simulate the records that it was fitted to: {wrong}; `robotid check` examines them"
    causes = ", and ".join(map(_clause, d.causes))
    if d.verdict == "named":
        left = f"; {rms(d.remaining, 2)} of {rms(d.misfit, 2)} {unit} remain" * (d.remaining < d.misfit)
        return f"{d.model} lacks {causes}{left}"
    place = "" if d.shape is None else f"; it is ordered best along {d.shape.along}"
    known = f"{d.model} lacks {causes}, and more" if causes else f"{d.model} is wrong by {rms(d.misfit, 2)} {unit}"
    return f"{known} that no effect of the catalogue explains{place}"


def _clause(cause: Cause) -> str:
    """A cause as part of a sentence."""
    others = [twin for twin in cause.twins if twin != cause.effect]
    alternatives = f" (or {', '.join(others)}: these data cannot tell)" if others else ""
    return f"{cause.effect}{alternatives}, which explains {percent(cause.explained)} %"


def rejected_document(one: Rejected) -> Json:
    """An effect that was tried and rejected."""
    return {
        "effect": one.effect,
        "explained": one.explained,
        "heldout_gain": one.heldout_gain,
        "why": one.why,
    }


def parameters_document(parameters: tuple[Estimate, ...], prefix: str = "") -> dict[str, Json]:
    """Values by name, or by symbol where all begin with a prefix."""
    return {
        p.name.removeprefix(prefix): {"value": p.value, "std": p.std, "std_robust": p.std_robust, "unit": p.unit}
        for p in parameters
    }


def _cause(cause: Cause) -> Json:
    found: dict[str, Json] = {
        "effect": cause.effect,
        "parameters": parameters_document(cause.parameters, f"{cause.effect}."),
        "explained": cause.explained,
        "heldout_gain": cause.heldout_gain,
        "p_value": cause.p_value,
        "class": cause.twins,
    }
    if cause.separation is not None:
        s = cause.separation
        found["separate_by"] = {"excite": _block(s), "against": s.against, "ratio": s.ratio}
    return found


def _block(separation: Separation) -> Json:
    """What goes under `excite:` of a record."""
    block = json.loads(separation.excite)
    inner: Json = block.get("excite", block)
    return inner


def _curve(curve: Curve, unit: str) -> Json:
    """A curve of the missing torque, in this unit."""
    return {
        "along": curve.along,
        "x": curve.x.tolist(),
        "x_unit": curve.unit,
        "missing_torque": curve.missing_torque.tolist(),
        "spread": curve.spread.tolist(),
        "count": curve.count.tolist(),
        "order": curve.order,
        "unit": unit,
    }


def _verdict(diagnosis: Diagnosis) -> Table:
    unit = diagnosis.unit
    facts = (
        ("verdict", diagnosis.verdict),
        (f"noise floor [{unit}]", rms(diagnosis.noise_floor)),
        (f"misfit beyond it [{unit}]", number(diagnosis.misfit, 3)),
        (f"what the causes leave [{unit}]", number(diagnosis.remaining, 3)),
    )
    return Table(f"Diagnosis of {diagnosis.model}", ("", ""), facts, "\n".join(diagnosis.remarks), VERDICTS)


def _records(diagnosis: Diagnosis) -> Table:
    unit = diagnosis.unit
    rows = tuple(
        (
            name,
            m.role,
            fixed(m.fit_percent),
            number(m.rmse, 3),
            rms(m.noise_floor),
            number(m.misfit, 3),
            percent(m.explained_after),
        )
        for name, m in diagnosis.records.items()
    )
    errors = (f"RMSE [{unit}]", f"noise floor [{unit}]", f"misfit [{unit}]")
    return Table("Records", ("record", "role", "fit [%]", *errors, "explained by the causes [%]"), rows)


def _curves(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """Where the missing torque sits, a row a variable."""
    rows = tuple((c.along, percent(c.order), *_largest(c), c.unit) for c in diagnosis.curves if len(c.x))
    columns = ("along", "orders [%]", "largest missing torque [Nm]", "there", "unit")
    note = "orders: share of the missing torque's variance that its mean along the variable explains"
    return (Table("Where the misfit sits", columns, rows, note),) if rows else ()


def _largest(curve: Curve) -> tuple[str, str]:
    k = int(np.nanargmax(np.abs(curve.missing_torque))) if np.isfinite(curve.missing_torque).any() else 0
    return number(float(curve.missing_torque[k]), 3), number(float(curve.x[k]), 3)


def _causes(diagnosis: Diagnosis) -> tuple[Table, ...]:
    if not diagnosis.causes:
        return ()
    rows = tuple(
        (
            cause.effect,
            percent(cause.explained),
            fixed(cause.heldout_gain),
            number(cause.p_value, 2),
            ", ".join(twin for twin in cause.twins if twin != cause.effect) or "-",
        )
        for cause in diagnosis.causes
    )
    columns = ("effect", "explains [%]", "held-out gain [% points]", "p", "cannot be told from")
    values = tuple(
        (p.name, number(p.value, 4), number(p.std_robust, 2), p.unit, p.remark)
        for cause in diagnosis.causes
        for p in cause.parameters
    )
    note = "explains: share of the misfit's energy, every frequency weighed by the noise that it has"
    return (
        Table("Causes", columns, rows, note),
        Table("Their parameters", ("parameter", "value", "sd", "unit", "remark"), values),
    )


def _separations(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """Experiments, each with what goes into a record, below the table to be copied."""
    found = [(c.effect, c.separation) for c in diagnosis.causes if c.separation is not None]
    rows = tuple((effect, s.against, number(s.ratio, 3)) for effect, s in found)
    blocks = (f"{effect} or {s.against}? excite: {json.dumps(_block(s))}" for effect, s in found)
    note = "\n".join(("difference: of the two models' outputs in that experiment, RMS over the noise", *blocks))
    columns = ("effect", "to be told from", "difference")
    return (Table("Experiments that tell causes apart", columns, rows, note),) if found else ()


def _rejected(diagnosis: Diagnosis) -> tuple[Table, ...]:
    return rejected_table("Tried and rejected", diagnosis.rejected)


def rejected_table(title: str, rejected: tuple[Rejected, ...]) -> tuple[Table, ...]:
    """A row an effect, with the reason."""
    rows = tuple((r.effect, percent(r.explained), fixed(r.heldout_gain), r.why) for r in rejected)
    columns = ("effect", "explains [%]", "held-out gain [% points]", "why not")
    return (Table(title, columns, rows),) if rows else ()


def _shape(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """The missing torque that nothing explains, at no more than a dozen places."""
    curve = diagnosis.shape
    if curve is None or not len(curve.x):
        return ()
    chosen = np.unique(np.linspace(0, len(curve.x) - 1, min(SHOWN, len(curve.x))).round().astype(int)).tolist()
    rows = tuple(
        (number(float(curve.x[k]), 3), number(float(curve.missing_torque[k]), 3), number(float(curve.spread[k]), 2))
        for k in chosen
    )
    head = f"{curve.along} [{curve.unit}]" if curve.unit else curve.along
    return (Table("Shape of what is unknown", (head, "missing torque [Nm]", "spread [Nm]"), rows),)
