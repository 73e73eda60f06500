"""Records from measured files: columns chosen, units converted, flaws mended."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

import numpy as np

from robotid.config.columns import ColumnSettings
from robotid.config.records import RecordSettings
from robotid.errors import ConfigError, InputError
from robotid.model.array import Array
from robotid.signals.columns import ALIASES, NEEDED, Column, convert, find, missing
from robotid.signals.quality import Report, inspect, speed_lag
from robotid.signals.readers.table import Table
from robotid.signals.record import Quantity, Record
from robotid.signals.repair import Mended, Policy, mend


def measured_record(settings: RecordSettings, table: Table, *, linear: bool) -> tuple[Record, Report]:
    """One record from its file. linear : a sliding axis, whose position does not wrap around.

    Raises ConfigError for columns that are not there, InputError for flaws that are refused.
    """
    columns, remarks = choose(settings, table)
    signals, turns = {}, {}
    for signal, column in columns.items():
        signals[signal], scale = convert(table, signal, column)
        if signal in ("phi_m", "phi_a") and not linear:
            turns[signal] = 2 * pi * scale
    _equal_lengths(table, signals)
    t = signals.pop("t", None)
    if t is None and settings.sampling_time is None:
        hint = f"name the time column under columns: t, or give sampling_time; {table.offer()}"
        raise ConfigError("neither a time column nor a sampling time is known", where=table.path, hint=hint)
    policy = Policy(**settings.repair.model_dump()) if settings.repair else Policy()
    mended = mend(table, signals, t, settings.sampling_time, turns, policy)
    record = _record(settings, mended, remarks)
    return record, inspect(record, table.path, mended, (*remarks, *mended.remarks))


def choose(settings: RecordSettings, table: Table) -> tuple[dict[str, Column], list[str]]:
    """Column by signal, from the configuration or by name, and what is to be said of it."""
    given = settings.columns.model_dump(exclude_unset=True) if settings.columns else {}
    chosen: dict[str, Column] = {}
    remarks: list[str] = []
    for signal in ALIASES:
        if signal in given:
            column = _given(getattr(settings.columns, signal))
        else:
            column = find(table, signal)
            unused = signal == "t" and settings.sampling_time is not None
            if column is not None:
                found = "not used, for sampling_time is given" if unused else "found by its name"
                remarks.append(f"{signal} is column {column.name}, {found}")
            column = None if unused else column
        if column is not None:
            chosen[signal] = column
        elif signal in NEEDED:
            raise missing(table, signal)
    return chosen, remarks


def _given(column: str | ColumnSettings | None) -> Column | None:
    if column is None or isinstance(column, str):
        return None if column is None else Column(column)
    return Column(column.name, column.column, column.unit, column.scale, column.offset)


def _equal_lengths(table: Table, signals: Mapping[str, Array]) -> None:
    lengths = {signal: len(values) for signal, values in signals.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{signal} {n}" for signal, n in lengths.items())
        raise InputError(f"columns differ in length: {listed}", where=table.path, hint="name columns of one recording")


def _record(settings: RecordSettings, mended: Mended, remarks: list[str]) -> Record:
    h, signals = mended.sampling_time, mended.signals
    derived = "dphi_m" not in signals
    speed = np.gradient(signals["phi_m"], h) if derived else signals["dphi_m"]
    if derived:
        remarks.append("dphi_m is derived from phi_m by central differences")
    elif (lag := speed_lag(signals["phi_m"], speed, h)) != 0:
        late = f"{abs(lag)} sample{'s' * (abs(lag) > 1)} {'late' if lag > 0 else 'early'}"
        remarks.append(f"dphi_m is {late} against the derivative of phi_m; `dphi_m: null` derives it instead")
    ref = signals.get("ref")
    return Record(
        name=settings.name,
        role=settings.role,
        use=settings.use,
        sampling_time=h,
        tau_m=signals["tau_m"],
        phi_m=signals["phi_m"],
        dphi_m=speed,
        phi_a=signals.get("phi_a"),
        ref=ref,
        ref_kind=None if ref is None else _kind(ref, signals["phi_m"], speed),
    )


def _kind(ref: Array, angle: Array, speed: Array) -> Quantity:
    """Whether a reference is one of position or of speed: what it is nearer to."""
    to_angle = np.std(ref - angle) / max(float(np.std(angle)), 1e-300)
    to_speed = np.std(ref - speed) / max(float(np.std(speed)), 1e-300)
    return "position" if to_angle <= to_speed else "speed"
