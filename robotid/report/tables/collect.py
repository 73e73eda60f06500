"""The records as tables and JSON: what was read, and the remarks on it."""

from __future__ import annotations

from robotid.numerals import number, significant
from robotid.report.tables import body
from robotid.report.tables.table import Json, Table
from robotid.signals.quality import Recordings, Report
from robotid.signals.record import Record

ROUNDING = 1e-9  # of the sampling time: what a jitter below it is


def tables(recordings: Recordings) -> tuple[Table, ...]:
    """One row a record in each table, the remarks, and the body of the robot."""
    return *of_axis(recordings), *of_robot(recordings)


def of_axis(recordings: Recordings) -> tuple[Table, ...]:
    """What each axis of a robot has of its own."""
    return _sampling(recordings), _signals(recordings), *_companions(recordings), *_remarks(recordings)


def of_robot(recordings: Recordings) -> tuple[Table, ...]:
    """What all axes of a robot have in common."""
    return () if recordings.body is None else body.tables(recordings.body)


def document(recordings: Recordings) -> Json:
    """The `collect --json` document."""
    records = {r.name: r for r in recordings.records}
    of_body = {} if recordings.body is None else {"body": body.document(recordings.body)}
    return {"records": {r.name: _entry(r, records[r.name]) for r in recordings.reports}, **of_body}


def _entry(r: Report, record: Record) -> Json:
    companions: dict[str, Json] = {"companions": _each(record)} if record.companions else {}
    return companions | {
        "source": r.source,
        "role": record.role,
        "use": record.use,
        "samples": r.samples,
        "sampling_time": r.sampling_time,
        "jitter": r.jitter,
        "mended": {"missing": r.missing, "duplicated": r.duplicated, "not_finite": r.not_finite, "wraps": r.wraps},
        "torque_range": r.torque_range,
        "angle_range": r.angle_range,
        "speed_range": r.speed_range,
        "quantum": r.quantum,
        "saturation": r.saturation,
        "torque_rms": r.torque_rms,
        "reversals": r.reversals,
        "still": r.still,
        "torque_bandwidth": r.torque_bandwidth,
        "remarks": r.remarks,
    }


def _each(record: Record) -> dict[str, Json]:
    return {
        name: {"kind": str(one.kind), "unit": one.unit, "range": (float(one.values.min()), float(one.values.max()))}
        for name, one in record.companions.items()
    }


def _sampling(recordings: Recordings) -> Table:
    uses = {r.name: (r.role, r.use) for r in recordings.records}
    rows = tuple(
        (
            r.name,
            *uses[r.name],
            str(r.samples),
            number(1e3 * r.sampling_time),
            significant(100 * r.jitter, 2) if r.jitter > ROUNDING else "0",
            str(r.missing),
            str(r.duplicated),
            str(r.not_finite),
            str(r.wraps),
            r.source,
        )
        for r in recordings.reports
    )
    columns = ("record", "role", "use", "samples", "Ts [ms]", "jitter [%]")
    repaired = ("missing", "duplicated", "not finite", "wraps", "source")
    return Table("Records", (*columns, *repaired), rows, "missing to wraps: samples that were repaired")


def _signals(recordings: Recordings) -> Table:
    rows = tuple(
        (
            r.name,
            _range(r.torque_range),
            _range(r.angle_range),
            _range(r.speed_range),
            number(r.quantum, 3) if r.quantum else "-",
            significant(100 * r.saturation, 2),
            str(r.reversals),
            significant(100 * r.still, 2),
            number(r.torque_bandwidth, 3),
        )
        for r in recordings.reports
    )
    ranges = ("torque", "motor angle", "motor speed", "quantum")
    counts = ("saturated [%]", "reversals", "at rest [%]", "torque up to [Hz]")
    return Table("Signals, in SI", ("record", *ranges, *counts), rows)


def _companions(recordings: Recordings) -> tuple[Table, ...]:
    rows = tuple(
        (r.name, name, str(one.kind), _range((float(one.values.min()), float(one.values.max()))), one.unit)
        for r in recordings.records
        for name, one in r.companions.items()
    )
    return (Table("Companions", ("record", "signal", "kind", "range", "unit"), rows),) if rows else ()


def _range(limits: tuple[float, float]) -> str:
    return f"{number(limits[0])} to {number(limits[1])}"


def _remarks(recordings: Recordings) -> tuple[Table, ...]:
    rows = tuple((r.name, remark) for r in recordings.reports for remark in r.remarks)
    return (Table("Remarks", ("record", "remark"), rows),) if rows else ()
