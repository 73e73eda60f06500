"""A log becomes a record: from a file, a data frame, or arrays."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np

from robotid.config.suggest import suggest
from robotid.errors import ConfigError
from robotid.interface.dataset import Dataset
from robotid.interface.hints import SIGNALS, in_python_terms
from robotid.model.companion import CompanionKind
from robotid.signals.columns import ALIASES, Column
from robotid.signals.measured import CompanionColumn, Selection, measured_records
from robotid.signals.readers import read as read_table
from robotid.signals.readers.delimited import without_unit
from robotid.signals.readers.table import Table, numeric
from robotid.signals.record import Role, Use
from robotid.signals.sampling import Policy

REPAIRS = {
    "gaps": ("refuse", "interpolate"),
    "nan": ("refuse", "interpolate"),
    "duplicates": ("refuse", "drop"),
    "wrap": ("refuse", "unwrap"),
}

ColumnLike = str | Column | Mapping[str, Any] | None
"""A column: its name, perhaps with a unit, "angle [deg]"; or a `rid.Column` or a mapping with name, unit, scale,
offset, column; None where there is none."""


class Columns(TypedDict, total=False):
    """Which column is what, and which part of the log is used; see `read`."""

    time: ColumnLike
    torque: ColumnLike
    angle: ColumnLike
    speed: ColumnLike
    arm_angle: ColumnLike
    reference: ColumnLike
    disturbance: ColumnLike
    start: float
    stop: float
    speed_delay: int
    torque_delay: float
    repair: Mapping[str, str]
    signals: Mapping[str, Mapping[str, Any]]


def read(
    source: Any,
    *,
    name: str | None = None,
    role: Role = "estimate",
    use: Use = "both",
    sampling_time: float | None = None,
    linear: bool = False,
    **columns: Unpack[Columns],
) -> Dataset:
    """Read one log or several into a dataset of records in SI units.

    source : a file (.csv .tsv .txt .lvm .jsonl .json .mat .h5 .npz, with an extra also .parquet .mcap .db3 .mf4), a
    pandas data frame, a mapping of names to arrays (n,), or a list of these, each a record.
    name : of the record, by default that of the file, and of a record from a frame or arrays "record". role :
    "estimate" serves the fit, "validate" is held out of it. use : which initialisation the record serves, "rigid",
    "flex" or "both". sampling_time [s] : instead of a time column. linear : the axis slides rather than turns.

    time, torque, angle, speed, arm_angle, reference, disturbance : which column is what; torque and angle are those of
    the motor, a disturbance is the part of the torque that the controller did not command.
    A column is a name, with its unit where the file does not tell it, "angle [deg]"; `rid.Column(name, unit=...,
    scale=..., offset=..., column=...)` turns volts into torque or picks a column of a matrix. A signal that is left out
    is found by its usual names; None means that there is none. A column without a unit is in SI.
    signals : companions by name, further columns that effects may read, {"q2": {"name": "axis2", "unit": "deg",
    "kind": "angle"}}; kind is angle (of another axis), temperature, torque (that acts beside the motor's), voltage
    or inertia.
    start, stop [s] : the part that is used, from the first sample. speed_delay [samples] : by which the speed is late;
    torque_delay [s] : by which the torque is late against the motion.
    repair : what is done about flaws, {"nan": "interpolate", "gaps": "interpolate", "duplicates": "drop", "wrap":
    "unwrap"} or "refuse" for each; by default a few samples are repaired, with a remark, and more are refused.

    Raises ConfigError for a column or unit that is not there, InputError for a file that cannot be read and for flaws
    that are refused, NumericsError for a record without excitation.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> log = motor_log()                   # {"time": ..., "torque": ..., "angle_deg": ...}, arrays of 2000 samples
    >>> data = rid.read(log, torque="torque [Nm]", angle="angle_deg")
    >>> data[0]
    <Record: record (estimate), 2000 samples at 500 Hz, 4 s>
    >>> rid.read(log, angle="angel_deg")
    Traceback (most recent call last):
    ...
    robotid.errors.ConfigError: arrays: there is no column "angel_deg"; did you mean angle_deg?
    """
    if _several(source):
        if name is not None:
            raise ConfigError(
                "several logs cannot have one name", where="read", hint="read them one by one, with names"
            )
        more: dict[str, Any] = {"role": role, "use": use, "sampling_time": sampling_time, "linear": linear, **columns}
        return _together([read(one, name=_numbered(one, k), **more) for k, one in enumerate(source)])
    with in_python_terms():
        table = _table(source)
        named = {key: _column(key, columns[key], table) for key in SIGNALS if key in columns}  # type: ignore[literal-required]
        selection = Selection(
            name=_name(source) if name is None else _checked_name(name),
            role=_one_of("role", role, ("estimate", "validate")),
            use=_one_of("use", use, ("rigid", "flex", "both")),
            columns={SIGNALS[key]: column for key, column in named.items()},
            sampling_time=sampling_time,
            linear=linear,
            companions={key: _companion(key, given, table) for key, given in columns.get("signals", {}).items()},
            **_rest(columns),
        )
        pairs = measured_records(selection, table)
    return Dataset(tuple(record for record, _ in pairs), tuple(report for _, report in pairs))


def _several(source: Any) -> bool:
    """Whether a source is a list of sources."""
    return isinstance(source, Sequence) and not isinstance(source, str | bytes)


def _numbered(source: Any, k: int) -> str | None:
    """A name for one of several sources that has none of its own."""
    return None if isinstance(source, str | Path) else f"record{k + 1}"


def _together(parts: Iterable[Dataset]) -> Dataset:
    data = Dataset()
    for part in parts:
        data = data + part
    return data


def _table(source: Any) -> Table:
    """The columns of a file, a frame or a mapping."""
    if isinstance(source, str | Path):
        return read_table(Path(source))
    frame = hasattr(source, "columns") and hasattr(source, "__getitem__")
    if not frame and not isinstance(source, Mapping):
        hint = "give a file, a data frame, or a mapping of names to arrays"
        raise ConfigError(f"a source of type {type(source).__name__} cannot be read", where="read", hint=hint)
    where = "data frame" if frame else "arrays"
    columns: dict[str, Any] = {}
    units: dict[str, str] = {}
    text: dict[str, str] = {}
    for key, signal in (_frame_columns(source) if frame else source).items():
        values, (plain, unit) = np.array(signal), without_unit(str(key))  # a copy: records share no memory with it
        found = dict(numeric(plain, _seconds(values)))
        columns |= found
        if unit and found:
            units[plain] = unit
        if not found and values.size and values.dtype.kind in "OUS":
            text[plain] = str(values.ravel()[0])
    if not columns:
        raise ConfigError("there is no column of numbers", where=where, hint="give torque and angle as arrays (n,)")
    return Table(where, columns, units, None, text)


def _frame_columns(frame: Any) -> dict[str, Any]:
    """The columns of a data frame by name, its index among them where that has a name."""
    columns = {str(key): frame[key] for key in frame.columns}
    index = getattr(frame, "index", None)
    name = getattr(index, "name", None)
    return columns if name is None else {str(name): index} | columns


def _seconds(values: Any) -> Any:
    """Dates as seconds since the first; anything else as it is."""
    if values.dtype.kind != "M":
        return values
    return (values - values[0]) / np.timedelta64(1, "s")


def _column(signal: str, given: ColumnLike, table: Table) -> Column | None:
    """A column as `read` was given it. A unit in the name counts where no column bears the whole name."""
    if given is None or isinstance(given, Column):
        return given
    if isinstance(given, str):
        plain, unit = without_unit(given)
        own = given in table.columns or not unit
        return Column(given if own else plain, unit=None if own else unit)
    if not isinstance(given, Mapping):
        raise ConfigError(f"{given!r} names no column", where=f"read, {signal}", hint="give a name or rid.Column(...)")
    known = [f.name for f in fields(Column)]
    for key in given:
        if key not in known:
            raise ConfigError(f'a column has no "{key}"', where=f"read, {signal}", hint=suggest(str(key), known))
    if "name" not in given:
        raise ConfigError("a column needs a name", where=f"read, {signal}", hint=table.offer())
    return Column(**given)


def _companion(signal: str, given: Mapping[str, Any], table: Table) -> CompanionColumn:
    """A companion as `read` was given it."""
    where, kinds = (
        f"read, signals, {signal}",
        [str(kind) for kind in CompanionKind if kind not in (CompanionKind.DISTURBANCE, CompanionKind.DRIVE)],
    )
    if signal in ALIASES:
        raise ConfigError(f"{signal} is a signal of the joint itself", where=where, hint="give it another name")
    if not isinstance(given, Mapping) or "kind" not in given:
        hint = f'give {{"name": ..., "kind": ...}}, its kind {", ".join(kinds[:-1])} or {kinds[-1]}'
        raise ConfigError("a companion needs a column and a kind", where=where, hint=hint)
    kind = CompanionKind(_one_of(f"signals, {signal}, kind", given["kind"], kinds))
    column = _column(f"signals, {signal}", {key: value for key, value in given.items() if key != "kind"}, table)
    assert column is not None
    return CompanionColumn(kind, column)


def _rest(given: Columns) -> dict[str, Any]:
    """The settings that are no columns."""
    others = ("start", "stop", "speed_delay", "torque_delay", "repair", "signals")
    for key in given:
        if key not in SIGNALS and key not in others:
            raise ConfigError(f'read takes no "{key}"', where="read", hint=suggest(key, [*SIGNALS, *others]))
    rest: dict[str, Any] = {key: given[key] for key in others[:4] if key in given}  # type: ignore[literal-required]
    repair = given.get("repair", {})
    for flaw, what in repair.items():
        if flaw not in REPAIRS:
            raise ConfigError(f'there is no flaw "{flaw}"', where="read, repair", hint=suggest(flaw, REPAIRS))
        _one_of(f"repair, {flaw}", what, REPAIRS[flaw])
    return rest | {"policy": Policy(**repair)}


def _one_of(where: str, given: Any, known: Sequence[str]) -> Any:
    if given not in known:
        raise ConfigError(f"{given!r} is unknown", where=f"read, {where}", hint=suggest(str(given), known))
    return given


def _name(source: Any) -> str:
    """A record's name from that of its file."""
    stem = Path(source).stem if isinstance(source, str | Path) else "record"
    return re.sub(r"[^A-Za-z0-9_-]+", "_", stem).lstrip("-") or "record"


def _checked_name(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_-]*", name):
        raise ConfigError(f'"{name}" is no name of a record', where="read", hint="use letters, digits, _ and -")
    return name
