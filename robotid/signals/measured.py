"""Records from tables of measured signals: columns chosen, units converted, flaws repaired."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

from robotid.errors import ConfigError, InputError, NumericsError
from robotid.model.array import Array, Mask
from robotid.model.companion import CompanionKind
from robotid.numerals import plain
from robotid.signals.clocks import on_one_clock
from robotid.signals.columns import (
    ALIASES,
    NEEDED,
    Column,
    Signal,
    convert,
    convert_companion,
    find,
    missing,
    remark_on,
)
from robotid.signals.companion import Companion
from robotid.signals.quality import MIN_SAMPLES, Report, inspect
from robotid.signals.readers.table import Table
from robotid.signals.record import OPERATORS, Quantity, Record, Role, SpeedOrigin, Use
from robotid.signals.repair import RepairedSignals, repair
from robotid.signals.resampling import mean_over_intervals, speed_error
from robotid.signals.sampling import HELD, NOTABLE_JITTER, ROUNDED, Findings, Grid, Policy, in_order, uninterrupted
from robotid.signals.speed_check import speed_lag, speed_origin, speed_scale
from robotid.signals.torque_steps import TorqueSteps, moved

ANGLES = ("phi_m", "phi_a", "ref")
NOTABLE = 0.03  # deviation of the recorded over the derived speed from 1 that is remarked
MAX_CONTRADICTION = 1.2  # factor between a sampling time and that of a column of time which it is given instead of


Rows = NDArray[np.intp]
"""Numbers of samples of a table, (n,)."""


@dataclass(frozen=True, slots=True)
class CompanionColumn:
    """Which column a companion is, and what it measures."""

    kind: CompanionKind
    column: Column


@dataclass(frozen=True, slots=True)
class Selection:
    """What of a table becomes a record, and how.

    columns : by signal (t, tau_m, phi_m, dphi_m, phi_a, ref, disturbance); one that is left out is found by its name,
    None says that there is none. sampling_time [s] : instead of a time column. start, stop [s] : the part that is used,
    counted from the first sample. speed_delay [samples] : by which the recorded speed is late. torque_delay [s] : by
    which the recorded torque is late against the motion. linear : the axis slides, and its position does not wrap
    around. companions : further signals by name.
    """

    name: str
    role: Role = "estimate"
    use: Use = "both"
    columns: Mapping[str, Column | None] = field(default_factory=dict)
    sampling_time: float | None = None
    start: float | None = None
    stop: float | None = None
    speed_delay: int = 0
    torque_delay: float = 0.0
    policy: Policy = field(default_factory=Policy)
    linear: bool = False
    companions: Mapping[str, CompanionColumn] = field(default_factory=dict)


def measured_records(chosen: Selection, table: Table) -> tuple[tuple[Record, Report], ...]:
    """The record of a table, with a report on what was found and repaired; several, name_1, name_2 and so on, where
    gaps that are too long to be bridged have cut it.

    Raises ConfigError for columns that are not there, InputError for flaws that are refused, NumericsError for a record
    without excitation.
    """
    found, remarks = read_signals(chosen, table)
    remarks = [*table.remarks, *remarks]
    _equal_lengths(table, found)
    t = found["t"].values if "t" in found else None
    if t is None and chosen.sampling_time is None:
        hint = f"name the time column under columns: t, or give sampling_time; {table.offer()}"
        raise ConfigError("neither a time column nor a sampling time is known", where=table.path, hint=hint)
    rows = np.flatnonzero(_kept(chosen, table, len(found["phi_m"].values), t))
    rows = rows if t is None else in_order(Findings(table, chosen.policy, rows, remarks), t, found["phi_m"].values)
    parts = [rows]
    if t is not None:
        parts = [rows[a:b] for a, b in uninterrupted(Findings(table, chosen.policy, rows), t[rows])]
    if len(parts) == 1:
        return (_measured_record(chosen, table, found, rows, remarks),)
    return _pieces(chosen, table, found, parts, remarks)


def _pieces(
    chosen: Selection, table: Table, found: Mapping[str, Signal], parts: Sequence[Rows], remarks: list[str]
) -> tuple[tuple[Record, Report], ...]:
    """Records of the parts that are long enough and excite. Raises InputError where there is none."""
    long = [rows for rows in parts if len(rows) >= MIN_SAMPLES]
    first = table.where(int(parts[1][0]))
    gaps = f"{len(parts) - 1} gaps, the first" if len(parts) > 2 else "a gap"
    pieces: list[tuple[Record, Report]] = []
    unfit: NumericsError | None = None
    for rows in long:
        name = f"{chosen.name}_{len(pieces) + 1}"
        try:
            record, report = _measured_record(replace(chosen, name=name), table, found, rows, remarks)
        except NumericsError as error:
            unfit = error
            continue
        pieces.append((replace(record, experiment=chosen.name), report))
    if not pieces and unfit is not None:
        raise unfit
    if not pieces:
        verb = "leave" if len(parts) > 2 else "leaves"
        what = f"{gaps} before {first} {verb} no {MIN_SAMPLES} samples in a row"
        raise InputError(what, where=table.path, hint="record again, or set repair: {gaps: interpolate}")
    lost = sum(map(len, parts)) - sum(len(record) for record, _ in pieces)
    left_out = f"; {lost} samples of parts that are too short or at rest are left out" if lost > 0 else ""
    verb = ", cut" if len(parts) > 2 else " cuts"
    cut = f"{gaps} before {first}{verb} the record into {_listed(pieces)}{left_out}"
    return tuple((record, replace(report, remarks=(cut, *report.remarks))) for record, report in pieces)


def _listed(pieces: Sequence[tuple[Record, Report]]) -> str:
    names = [record.name for record, _ in pieces]
    return f"{names[0]} to {names[-1]}" if len(names) > 2 else " and ".join(names)


def _measured_record(
    chosen: Selection, table: Table, found: Mapping[str, Signal], rows: Rows, remarks: Sequence[str]
) -> tuple[Record, Report]:
    """One record of these rows of a table, and the report on it."""
    wanted = _as_slice(rows)
    t = found["t"].values[wanted] if "t" in found else None
    signals = {name: signal.values[wanted] for name, signal in found.items() if name != "t"}
    flaws = Findings(table, chosen.policy, rows)
    repaired = repair(flaws, signals, t, chosen.sampling_time, _turns(chosen, found))
    record = _record(chosen, repaired, found)
    found_remarks = [*remarks, *repaired.remarks]
    if len(record) > 2:
        found_remarks += _clock_remarks(chosen, repaired.grid, record, derived="dphi_m" not in found)
        found_remarks += _speed_remarks(chosen, record, derived="dphi_m" not in found)
    return record, inspect(record, table.path, repaired, tuple(found_remarks))


def _as_slice(rows: Rows) -> slice | Rows:
    """Rows that follow each other as a slice, which copies nothing."""
    if len(rows) and (np.diff(rows) == 1).all():
        return slice(int(rows[0]), int(rows[-1]) + 1)
    return rows


def _clock_remarks(chosen: Selection, grid: Grid, record: Record, *, derived: bool) -> list[str]:
    """What the clock did, and what it would have cost."""
    h = grid.sampling_time
    if not len(grid.late) or float(np.std(grid.late)) <= NOTABLE_JITTER * h:
        return []
    sizes = ((grid.jitter_rms, "RMS"), (grid.jitter, "at most"))
    jitter = " and ".join(f"{plain(1e3 * h * share, 2)} ms ({plain(100 * share, 2)} %) {what}" for share, what in sizes)
    if not grid.resampled:
        if float(np.abs(grid.late).max()) <= ROUNDED * grid.resolution:
            return []
        return [
            f"the time stamps jitter by {jitter}, but phi_m is smoother without them: sampled every {1e3 * h:.6g} ms"
        ]
    cost = speed_error(grid.late, record.dphi_m, h, derived=derived)
    unit = "m/s" if chosen.linear else "rad/s"
    ignored = f"ignored, the jitter would be an error of {plain(cost, 2)} {unit} RMS in the speed"
    return [f"sampling intervals jitter by {jitter}: resampled on the time stamps, every {1e3 * h:.6g} ms; {ignored}"]


def _turns(chosen: Selection, found: Mapping[str, Signal]) -> dict[str, tuple[float, ...]]:
    """Angles at which each may wrap around [rad]: a turn of what was recorded, and one of what it is scaled to."""
    angles = [] if chosen.linear else [name for name in ANGLES if name in found]
    angles += [name for name, one in chosen.companions.items() if one.kind is CompanionKind.ANGLE]
    return {name: (2 * pi, 2 * pi * abs(found[name].scale)) for name in angles}


def read_signals(chosen: Selection, table: Table) -> tuple[dict[str, Signal], list[str]]:
    """Signals by name in SI, from the columns given or those found by name, and remarks on them."""
    given, columns = chosen.columns, _columns(chosen, table)
    further = {
        name: replace(one, column=replace(one.column, name=table.at_position(one.column.name)))
        for name, one in chosen.companions.items()
    }
    table, remarks = on_one_clock(table, columns | {name: one.column for name, one in further.items()})
    found: dict[str, Signal] = {}
    for name, one in further.items():
        found[name] = convert_companion(table, name, one.kind, one.column)
        remarks += [found[name].remark] if found[name].remark else []
    for signal, column in columns.items():
        if signal == "t" and chosen.sampling_time is not None and signal not in given:
            other = _contradiction(convert(table, signal, column).values, chosen.sampling_time)
            remarks.append(f"t is column {column.name}, not used, for sampling_time is given{other}")
            continue
        found[signal] = convert(table, signal, column, linear=chosen.linear)
        by_name = signal not in given and column.name not in table.clocks.values()
        remarks += [remark_on(signal, column, found[signal])] if by_name else []
        remarks += [found[signal].remark] if found[signal].remark else []
    return found, remarks


def _contradiction(t: Array, sampling_time: float) -> str:
    """What a column of time (n,) that is not used says of the sampling time [s] that it is left out for."""
    known = t[np.isfinite(t)]
    mean = float(known[-1] - known[0]) / (len(known) - 1) if len(known) > 1 else 0.0
    if not mean > 0.0 or 1 / MAX_CONTRADICTION < mean / sampling_time < MAX_CONTRADICTION:
        return ""
    return f": {sampling_time:.6g} s, where the column has {mean:.6g} s between two samples; is that right?"


def _columns(chosen: Selection, table: Table) -> dict[str, Column]:
    """Columns by signal, as given or found by name; the time stamps of the angle where the file has them."""
    given, taken = chosen.columns, {one.column.name for one in chosen.companions.values()}
    found: dict[str, Column | None] = {}
    for signal in ALIASES:
        if signal in given:
            chosen_column = given[signal]
            found[signal] = chosen_column and replace(chosen_column, name=table.at_position(chosen_column.name))
        elif signal == "t" and table.clocks:
            found[signal] = None
        else:
            found[signal] = find(table, signal, linear=chosen.linear, taken=taken)
        if found[signal] is None and signal in NEEDED:
            raise missing(table, signal)
    angle = found["phi_m"]
    clock = None if angle is None else table.clock(angle.name)
    if "t" not in given and clock is not None:
        found["t"] = Column(clock)
    return {signal: column for signal, column in found.items() if column is not None}


def _equal_lengths(table: Table, signals: Mapping[str, Signal]) -> None:
    lengths = {name: len(signal.values) for name, signal in signals.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {n}" for name, n in lengths.items())
        raise InputError(f"columns differ in length: {listed}", where=table.path, hint="name columns of one recording")


def _kept(chosen: Selection, table: Table, n: int, t: Array | None) -> Mask:
    """Samples between start and stop, counted in seconds from the first sample, (n,)."""
    start, stop = chosen.start or 0.0, chosen.stop
    if chosen.start is None and stop is None:
        return np.ones(n, dtype=np.bool_)
    h = chosen.sampling_time or 1.0
    clock = np.arange(n) * h if t is None else t - t[np.argmax(np.isfinite(t))]
    slack = 1e-9 * max(1.0, start)
    kept = np.asarray((clock >= start - slack) & (clock <= (np.inf if stop is None else stop + slack)))
    if not kept.any():
        what = f"no sample lies between start {start:g} s and stop" + ("" if stop is None else f" {stop:g} s")
        last = float(np.nanmax(clock))
        raise ConfigError(what, where=table.path, hint=f"the record is {last:.6g} s long")
    return kept


def _record(chosen: Selection, repaired: RepairedSignals, found: Mapping[str, Signal]) -> Record:
    h = repaired.grid.sampling_time
    signals, steps = _without_torque_delay(chosen, repaired)
    late = chosen.speed_delay if "dphi_m" in signals else 0
    n = len(signals["phi_m"])
    if abs(late) > n // 2:
        raise ConfigError(f"speed_delay is {late} samples, of {n}", where=chosen.name, hint="give samples, not a time")
    first, last = max(0, -late), n - max(0, late)
    cut = {
        name: values[first + late : last + late] if name == "dphi_m" else values[first:last]
        for name, values in signals.items()
    }
    angle = cut["phi_m"]
    origin: SpeedOrigin = "central difference"
    if "dphi_m" in cut:
        origin = "sensor" if late else speed_origin(angle, cut["dphi_m"], h)
    speed = cut["dphi_m"] if origin == "sensor" else _derived(angle, h, origin)
    ref = cut.get("ref")
    return Record(
        name=chosen.name,
        role=chosen.role,
        use=chosen.use,
        sampling_time=h,
        tau_m=cut["tau_m"],
        phi_m=angle,
        dphi_m=speed,
        phi_a=cut.get("phi_a"),
        ref=ref,
        ref_kind=None if ref is None else _kind(found["ref"], ref, angle, speed),
        companions=_companions(chosen, cut, h),
        speed_origin=origin,
        torque_steps=None if steps is None else steps.take(slice(first, last)),
    )


def _companions(chosen: Selection, signals: Mapping[str, Array], h: float) -> dict[str, Companion]:
    """The further signals of a record, by name. A disturbance among the columns is one of them."""
    kinds = {name: one.kind for name, one in chosen.companions.items()}
    if "disturbance" in signals:
        kinds["disturbance"] = CompanionKind.DISTURBANCE
    return {name: Companion.of(kind, signals[name], h) for name, kind in kinds.items()}


def _without_torque_delay(chosen: Selection, repaired: RepairedSignals) -> tuple[dict[str, Array], TorqueSteps | None]:
    """Signals where the torque, and what is part of it, is that of its time, and how the torque changes within
    intervals; the ends where it is not known are cut."""
    h, signals, steps = repaired.grid.sampling_time, repaired.signals, repaired.torque_steps
    late, n = chosen.torque_delay / h, len(signals["phi_m"])
    if late == 0.0:
        return signals, steps
    if abs(late) > n / 2:
        what = f"torque_delay is {chosen.torque_delay:g} s, of {n * h:.6g} s"
        raise ConfigError(what, where=chosen.name, hint="give seconds")
    first, last = max(0, ceil(-late)), n - max(0, ceil(late))
    at, then = np.arange(n, dtype=np.float64), np.arange(first, last, dtype=np.float64) + late
    found = {
        name: mean_over_intervals(at, values, then) if name in HELD else values[first:last]
        for name, values in signals.items()
    }
    if steps is not None:
        torque, steps = moved(signals["tau_m"], steps, -late)
        found["tau_m"], steps = torque[first:last], None if steps is None else steps.take(slice(first, last))
    return found, steps


def _derived(angle: Array, h: float, origin: SpeedOrigin) -> Array:
    return OPERATORS[origin](angle, h) if len(angle) > 2 else np.zeros_like(angle)


def _speed_remarks(chosen: Selection, record: Record, *, derived: bool) -> list[str]:
    """The remark on the speed."""
    if derived:
        return ["dphi_m is derived from phi_m by central differences"]
    angle, speed, h = record.phi_m, record.dphi_m, record.sampling_time
    if record.speed_is_derived:
        return [f"dphi_m is the {record.speed_origin} of phi_m, and simulated alike"]
    remarks = [f"dphi_m is advanced by speed_delay: {chosen.speed_delay}"] if chosen.speed_delay else []
    scale = speed_scale(angle, speed, h)
    if scale is not None and abs(scale - 1) > NOTABLE:
        remarks.append(f"dphi_m is {plain(scale)} times the derivative of phi_m; is one of them scaled wrong?")
    lag = speed_lag(angle, speed, h)
    if lag:
        much = f"{abs(lag):.1f} sample{'s' * (abs(lag) >= 1.05)} {'late' if lag > 0 else 'early'}"
        shift = f"speed_delay: {chosen.speed_delay + round(lag)} or " if abs(lag) > 0.75 else ""
        remarks.append(f"dphi_m is {much} against the derivative of phi_m; {shift}dphi_m: null removes it")
    return remarks


def _kind(signal: Signal, ref: Array, angle: Array, speed: Array) -> Quantity:
    """Whether a reference is one of position or of speed: as its unit says, or else what it is nearer to."""
    if signal.unit is not None and not signal.unit.raw:
        return "speed" if signal.unit.quantity in ("angular speed", "speed") else "position"
    to_angle = np.std(ref - angle) / max(float(np.std(angle)), 1e-300)
    to_speed = np.std(ref - speed) / max(float(np.std(speed)), 1e-300)
    return "position" if to_angle <= to_speed else "speed"
