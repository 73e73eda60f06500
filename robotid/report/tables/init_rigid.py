"""The rigid-body estimate as tables and JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.numerals import fixed, number
from robotid.report.tables.estimates import estimates_document
from robotid.report.tables.table import Json, Table

if TYPE_CHECKING:
    from robotid.estimate.rigid import RigidResult


def tables(rigid: RigidResult) -> tuple[Table, ...]:
    """Parameters, and the torque error of each record."""
    rows = tuple((p.name, number(p.value, 5), number(p.std_robust, 2), p.unit, p.remark) for p in rigid.parameters)
    robust = "sd: standard deviation that allows for coloured residuals"
    note = "\n".join((robust, f"condition number {number(rigid.condition_number, 3)}", *rigid.remarks))
    errors = tuple(
        (name, fixed(error), number(rigid.cutoff.get(name), 3)) for name, error in rigid.torque_error_percent.items()
    )
    return (
        Table("Rigid-body parameters", ("parameter", "value", "sd", "unit", "remark"), rows, note),
        Table("Torque error", ("record", "error [%]", "cut-off [Hz]"), errors),
    )


def document(rigid: RigidResult) -> Json:
    """The `init-rigid --json` document of docs/command-line.md."""
    return {
        "parameters": estimates_document(rigid.parameters),
        "condition_number": rigid.condition_number,
        "torque_error_percent": rigid.torque_error_percent,
        "remarks": rigid.remarks,
    }
