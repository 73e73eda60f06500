"""The identified body as tables and JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.numerals import fixed, number, percent
from robotid.report.tables.table import Json, Table

if TYPE_CHECKING:
    from robotid.body.results import BodyParameter, BodyResult

IN_PLACE_OF_NOTHING = 1e-12


def tables(body: BodyResult) -> tuple[Table, ...]:
    """Torque errors, the parameters of links and drives, and the base parameters."""
    return (_errors(body), _parameters(body), _base(body))


def document(body: BodyResult) -> Json:
    """The `body` of the `collect --json` document of docs/command-line.md."""
    return {
        "axes": body.axes,
        "condition_number": body.condition_number,
        "torque_error_percent": {e.record: {"base": e.base, "consistent": e.consistent} for e in body.errors},
        "cutoff_hz": body.cutoff,
        "base": {
            b.name: {"value": _known(b.value), "std": _known(b.std), "unit": b.unit, "seen": b.seen} for b in body.base
        },
        "parameters": {
            p.name: {
                "value": p.value,
                "std": p.std,
                "unit": p.unit,
                "start": _known(p.start),
                "seen": p.seen,
                "fixed": p.fixed,
            }
            for p in body.parameters
        },
        "remarks": body.remarks,
    }


def _known(value: float) -> float | None:
    """A number, None where there is none: JSON knows no nan."""
    return value if value == value else None


def _errors(body: BodyResult) -> Table:
    rows = tuple(
        (errors.record, "fitted" if errors.fitted else "held out", kind, *(fixed(one, 1) for one in values))
        for errors in body.errors
        for kind, values in (("base", errors.base), ("consistent", errors.consistent))
    )
    cutoffs = ", ".join(f"{number(cutoff, 3)} Hz ({name})" for name, cutoff in body.cutoff.items())
    note = (
        "base: least squares of the base parameters; consistent: parameters that a body can have, near their start "
        "where the motions show nothing; the simulation uses these"
    )
    return Table(
        "Body: torque error [%]", ("record", "role", "parameters", *body.axes), rows, f"{note}\ncut-off {cutoffs}"
    )


def _parameters(body: BodyResult) -> Table:
    free = sorted((p for p in body.parameters if not p.fixed), key=lambda p: -_share(p))
    rows = tuple(
        (
            p.name,
            number(p.value),
            number(None if p.fixed else p.std, 2),
            number(p.start),
            "fixed" if p.fixed else percent(p.seen, 0) if p.start == p.start else "-",
            p.unit,
        )
        for p in (*free, *(p for p in body.parameters if p.fixed))
    )
    note = (
        "seen: share of the start's variance that the data took away; 0 keeps the start; what is seen best stands first"
    )
    columns = ("parameter", "value", "sd", "start", "seen [%]", "unit")
    return Table("Body: links and drives, behind the gears", columns, rows, "\n".join((note, *body.remarks)))


def _base(body: BodyResult) -> Table:
    rows = tuple(
        (b.name, number(b.value), number(b.std, 2), number(_percent(b.value, b.std), 2) if b.seen else "-", b.unit)
        for b in sorted(body.base, key=lambda b: (not b.seen, _percent(b.value, b.std) if b.seen else 0.0))
    )
    note = (
        f"condition number {number(body.condition_number, 3)} of the columns scaled to unit norm; no prior knowledge; "
        "the most precise stand first"
    )
    return Table("Body: base parameters", ("sum of parameters", "value", "sd", "sd [%]", "unit"), rows, note)


def _share(p: BodyParameter) -> float:
    """How much of a parameter the data determined; of one without a start, by its own size in place of what it was
    expected to be."""
    return p.seen if p.start == p.start else 1.0 - (p.std / max(abs(p.value), p.std, IN_PLACE_OF_NOTHING)) ** 2


def _percent(value: float, std: float) -> float:
    return 100 * std / max(abs(value), IN_PLACE_OF_NOTHING)
