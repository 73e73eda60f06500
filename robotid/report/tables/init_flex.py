"""The flexible initialisation as tables and JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.numerals import number
from robotid.report.tables.table import Json, Table

if TYPE_CHECKING:
    from robotid.estimate.flexible import FlexReading, FlexResult


def tables(flex: FlexResult) -> tuple[Table, ...]:
    """What each response tells, the parametric fit, the spring laws, and the start of the fit."""
    found = [_readings(flex), _fits(flex), _springs(flex)] if flex.readings else []
    return (*found, _parameters(flex))


def document(flex: FlexResult) -> Json:
    """The `init-flex --json` document."""
    return {
        "parameters": {p.name: {"value": p.value, "std": p.std, "unit": p.unit} for p in flex.parameters},
        "responses": {reading.record: _response(reading) for reading in flex.readings},
        "springs": {law.method: {"k1": law.k1, "k3": law.k3, "k3_std": law.k3_std} for law in flex.springs},
        "guesses": flex.guesses,
        "remarks": flex.remarks,
    }


def _response(reading: FlexReading) -> Json:
    return {
        "notch": reading.notch,
        "resonance": reading.resonance,
        "gain": reading.gain,
        "Jm": reading.Jm,
        "k": reading.k,
        "values": reading.values,
        "misfit": reading.misfit,
        "twist": reading.twist,
    }


def _readings(flex: FlexResult) -> Table:
    columns = ("record", "notch [rad/s]", "resonance [rad/s]", "Jm [kg m2]", "k [Nm/rad]", "largest twist [rad]")
    rows = tuple(
        (r.record, number(r.notch), number(r.resonance), number(r.Jm), number(r.k), number(r.twist, 3))
        for r in flex.readings
    )
    return Table("Read off the frequency responses", columns, rows)


def _fits(flex: FlexResult) -> Table:
    """The parametric fits of eq. (13), a row a response."""
    names = tuple(dict.fromkeys(name for r in flex.readings for name in r.values))
    rows = tuple((r.record, *(_value(r, name) for name in names), number(r.misfit, 3)) for r in flex.readings)
    note = "misfit about 1: a linear joint explains the response"
    return Table("Fit of a linear joint to the responses", ("record", *names, "misfit"), rows, note)


def _value(reading: FlexReading, name: str) -> str:
    return number(reading.values.get(name, float("nan")))


def _springs(flex: FlexResult) -> Table:
    columns = ("method", "k1 [Nm/rad]", "k3 [Nm/rad3]", "sd of k3")
    rows = tuple((law.method, number(law.k1), number(law.k3), number(law.k3_std, 2)) for law in flex.springs)
    return Table("Spring law over the records", columns, rows)


def _parameters(flex: FlexResult) -> Table:
    rows = tuple((p.name, number(p.value, 5), number(p.std, 2), p.unit, p.remark) for p in flex.parameters)
    return Table("Start of the fit", ("parameter", "value", "sd", "unit", "remark"), rows, "\n".join(flex.remarks))
