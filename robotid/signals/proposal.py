"""A guess at what a file's columns are, for a person to correct: by their names, units and time steps."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robotid.model.array import Array
from robotid.signals.columns import ALIASES, NEEDED, Column, ending
from robotid.signals.joining import joined
from robotid.signals.proposed_time import dated, sampling_time
from robotid.signals.readers import read
from robotid.signals.readers.table import Table
from robotid.signals.units import UNITS, parse

WORDS = {
    "t": {"t", "time", "timestamp", "zeit", "clock"},
    "tau_m": {
        "tau",
        "torque",
        "trq",
        "moment",
        "drehmoment",
        "force",
        "effort",
        "u",
        "vir",
        "volt",
        "voltage",
        "current",
    },
    "dphi_m": {"dphi", "dq", "qd", "dtheta", "omega", "speed", "velocity", "vel", "drehzahl"},
    "phi_m": {"phi", "angle", "ang", "pos", "position", "q", "qm", "theta", "enc", "encoder", "winkel"},
}
REFERENCE = {"ref", "reference", "setpoint", "desired", "des", "target", "cmd", "command", "soll", "qg"}
CERTAIN = 9
DERIVED = 0.95  # correlation from which a column is the derivative of another
SAME_SCALE = 0.2  # by which the numbers of a reference and of what follows it may differ: no two units do by so little
MEASURED = {"mot", "motor", "act", "actual", "meas", "measured"}
ARM = {"arm", "link", "load", "se", "second", "secondary", "output", "qa", "ql"}

SIGNAL = {
    **dict.fromkeys(("time",), "t"),
    **dict.fromkeys(("torque", "force", "voltage", "current", "share"), "tau_m"),
    **dict.fromkeys(("angular speed", "speed"), "dphi_m"),
    **dict.fromkeys(("angle", "length", "count"), "phi_m"),
}
"""What a quantity is first taken for."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """Columns by signal and the sampling time [s] of files that are joined by time, as guessed. remarks : what a
    person should check; left_out : signals that are not to be found by name either; axes : columns by signal of each
    axis, none where the file holds one."""

    paths: tuple[Path, ...]
    columns: dict[str, Column]
    sampling_time: float | None
    remarks: tuple[str, ...]
    left_out: tuple[str, ...] = ()
    axes: tuple[dict[str, Column], ...] = ()


@dataclass(frozen=True, slots=True)
class _Guess:
    """What a column may be. certainty : 1 by its unit, 2 by a word of its name and more by words that say that it was
    measured, 9 by a usual name, 10 by a person."""

    signal: str
    certainty: int
    column: Column


def propose(*paths: Path, chosen: Mapping[str, str] | None = None) -> Proposal:
    """Columns and sampling time of a file, or of several that are joined by time. chosen : columns by signal that a
    person has named.

    Raises InputError where a file cannot be read, ConfigError where a chosen column is not there.
    """
    table = joined([read(path) for path in paths])
    named = {signal: _chosen(table, name) for signal, name in (chosen or {}).items()}
    remarks: list[str] = []
    unnamed = bool(table.columns) and all(name.isdecimal() for name in table.columns)
    if unnamed:
        guesses = _by_values(table)
        remarks.append("the file has no names: columns are guessed by their values, and units are SI")
    else:
        guesses = [guess for name in _recorded(table) if (guess := _guess(table, name)) is not None]
    taken = [column.name for column in named.values()]
    guesses = [guess for guess in guesses if guess.column.name not in taken]
    guesses += [_Guess(signal, CERTAIN + 1, column) for signal, column in named.items()]
    columns: dict[str, Column] = {}
    for signal in ALIASES:
        fitting = sorted((g for g in guesses if g.signal == signal), key=lambda g: -g.certainty)
        moving = [g for g in fitting if len(fitting) == 1 or _changes(table, g.column)]
        if moving and len(moving) < len(fitting):
            left_out = ", ".join(g.column.name for g in fitting if g not in moving)
            remarks.append(f"{left_out} could also be {signal}, and never changes")
        fitting = moving or fitting
        if fitting:
            columns[signal] = fitting[0].column
            remarks += _said(signal, fitting)
        elif signal in NEEDED:
            alone = ", and a speed alone is not enough" if signal == "phi_m" and _has_speed(guesses) else ""
            remarks.append(f"no column looks like {signal}{alone}; {table.offer()}")
    if "phi_m" in columns and (clock := table.clock(columns["phi_m"].name)) is not None:
        columns = {"t": Column(clock)} | columns
    if "t" in columns and "t" not in named:
        columns["t"] = dated(table, columns["t"], remarks)
    h = sampling_time(table, columns.get("t"), remarks)
    if "ref" in columns and columns["ref"].unit is None:
        columns["ref"] = replace(columns["ref"], unit=_followed(table, columns, remarks))
    return Proposal(paths, columns, h, tuple(remarks), axes=_axes(table, columns))


def _has_speed(guesses: Sequence[_Guess]) -> bool:
    return any(guess.signal == "dphi_m" for guess in guesses)


def _axes(table: Table, columns: Mapping[str, Column]) -> tuple[dict[str, Column], ...]:
    """The columns of each axis, where a file has torque and angle of several: in matrices of one width, or under names
    that differ in a number alone."""
    own = {signal: column for signal, column in columns.items() if signal != "t"}
    if not all(signal in own for signal in NEEDED):
        return ()
    found = {signal: _alike(table, column) for signal, column in own.items()}
    numbers = sorted(set.intersection(*(set(found[signal]) for signal in NEEDED)))
    places = [(one.name, one.column) for each in found.values() for one in each.values()]
    if len(numbers) < 2 or len({*places}) < len(places):  # a number that tells signals apart tells no axes
        return ()
    return tuple({signal: each[n] for signal, each in found.items() if n in each} for n in numbers)


def _alike(table: Table, column: Column) -> dict[int, Column]:
    """The same signal of all axes by their numbers, as far as its column tells."""
    if column.column is not None:
        return {k: replace(column, column=k) for k in range(max(1, *table.shape(column.name)[1:]))}
    name, best = column.name, dict[int, Column]()
    for number in re.finditer(r"\d+", name):
        pattern = re.compile(re.escape(name[: number.start()]) + r"(\d+)" + re.escape(name[number.end() :]))
        matches = ((pattern.fullmatch(other), other) for other in table.columns)
        found = {int(match[1]): replace(column, name=other) for match, other in matches if match}
        best = max(best, found, key=len)
    return best


def _recorded(table: Table) -> list[str]:
    """Columns of the commonest length: what else a file holds was not recorded with them.

    Where each has its time stamps, all but these.
    """
    if table.clocks:
        return [name for name in table.columns if name not in table.clocks.values()]
    lengths = {name: max(table.shape(name)) for name in table.columns}
    total = Counter(lengths.values())
    usual = max(total, key=lambda length: length * total[length], default=0)
    return [name for name, length in lengths.items() if length == usual]


def _chosen(table: Table, name: str) -> Column:
    """A column that a person named, by name or position, with its unit. Raises ConfigError where it is not there."""
    stored = table.at_position(name)
    first = None if len(table.shape(stored) if stored in table.columns else (0,)) == 1 else 0
    table.pick(stored, first)
    unit = parse(table.units.get(stored, "")) or ending(stored)[1]
    return Column(stored, first, unit.name if unit else None, 1.0 if unit is not None and unit.raw else None)


def _by_values(table: Table) -> list[_Guess]:
    """What columns without names may be: a time steps evenly, a speed is the derivative of its angle, and of two that
    are left the angle is the smoother."""
    left = {name: values for name in table.columns if np.isfinite(values := table.pick(name)).all() and np.ptp(values)}
    found: dict[str, str] = {}
    time = next((name for name, values in left.items() if _is_time(values)), None)
    if time is not None:
        found["t"] = time
        del left[time]
    pairs = [(abs(_derived(left[a], left[b])), a, b) for a in left for b in left if a != b]
    best = max(pairs, default=(0.0, "", ""))
    if best[0] > DERIVED and len(left) > 2:
        found |= {"phi_m": best[1], "dphi_m": best[2]}
        rest = [name for name in left if name not in best[1:]]
        found |= {"tau_m": rest[0]} if len(rest) == 1 else {}
    elif len(left) == 2:
        angle, torque = sorted(left, key=lambda name: _unsteadiness(left[name]))
        found |= {"phi_m": angle, "tau_m": torque}
    return [_Guess(signal, 1, Column(name)) for signal, name in found.items()]


def _changes(table: Table, column: Column) -> bool:
    values = table.pick(column.name, column.column)
    return bool(np.nanmax(values) > np.nanmin(values)) if np.isfinite(values).any() else False


def _followed(table: Table, columns: Mapping[str, Column], remarks: list[str]) -> str | None:
    """The unit of a reference that names none: that of the signal by whose numbers it is followed, None for SI."""
    known = [columns[s] for s in ("phi_m", "dphi_m") if s in columns and columns[s].unit is not None]
    known = [column for column in known if UNITS[column.unit or ""].factor != 1.0]
    ref = columns["ref"]
    values = table.pick(ref.name, ref.column)
    for column in known:
        followed = table.pick(column.name, column.column)
        both = np.isfinite(values) & np.isfinite(followed)
        if not both.any() or not np.ptp(values[both]) or not np.ptp(followed[both]):
            continue
        slope = float(np.cov(values[both], followed[both])[0, 1] / np.var(values[both], ddof=1))
        alike = float(np.corrcoef(values[both], followed[both])[0, 1]) > DERIVED
        if alike and abs(slope - 1.0) < SAME_SCALE:
            remarks.append(f"{ref.name} is taken to be in {column.unit}: {column.name} follows its numbers")
            return column.unit
    if known:
        remarks.append(f"{ref.name} names no unit and is taken for SI; give its unit if it is in another")
    return None


def _is_time(values: Array) -> bool:
    steps = np.diff(values)
    return bool((steps > 0).all() and float(np.percentile(np.abs(steps / np.median(steps) - 1), 95)) < 0.5)


def _derived(angle: Array, speed: Array) -> float:
    """Correlation of a signal with the derivative of another."""
    derivative = np.gradient(angle)
    return float(np.corrcoef(derivative, speed)[0, 1]) if np.ptp(derivative) else 0.0


def _unsteadiness(values: Array) -> float:
    return float(np.std(np.diff(values)) / np.std(values))


def _guess(table: Table, name: str) -> _Guess | None:
    stem, suffix = ending(name)
    unit = parse(table.units.get(name, "")) or suffix
    words = {word.rstrip("0123456789") or word for word in stem.split("_")} | set(stem.split("_"))
    signal, certainty = _signal(stem, words, SIGNAL[unit.quantity] if unit else None)
    if signal is None:
        return None
    scale = 1.0 if unit is not None and unit.raw else None
    column = Column(name, None if len(table.shape(name)) == 1 else 0, unit.name if unit else None, scale)
    return _Guess(signal, certainty, column)


def _signal(name: str, words: set[str], kind: str | None) -> tuple[str | None, int]:
    exact = next((signal for signal, aliases in ALIASES.items() if name in aliases), None)
    if exact is not None and kind in (None, exact, {"phi_a": "phi_m", "ref": kind}.get(exact)):
        return exact, CERTAIN
    spoken = next((signal for signal, usual in WORDS.items() if words & (usual | set(ALIASES[signal]))), None)
    signal = kind or spoken
    if words & REFERENCE and signal in ("phi_m", "dphi_m", None):
        return "ref", 2
    if signal == "phi_m" and words & ARM:
        return "phi_a", 2
    return signal, (2 if spoken == signal else 1) + len(words & MEASURED)


def _said(signal: str, fitting: list[_Guess]) -> list[str]:
    column = fitting[0].column
    if fitting[0].certainty > CERTAIN:
        fitting = fitting[:1]
    remarks = [] if fitting[0].certainty >= CERTAIN else [f"{signal} is guessed to be column {column.name}"]
    if others := [g.column.name for g in fitting[1:]]:
        remarks.append(f"{signal} could also be {', '.join(others[:4])}{', ...' * (len(others) > 4)}")
    if column.column is not None:
        remarks.append(f"{column.name} is a matrix, one column a joint; column 0 is proposed")
    if column.unit is not None and UNITS[column.unit].raw:
        what = "torque" if signal == "tau_m" else "SI"
        remarks.append(f"{column.name} is in {column.unit}; give the {what} per {column.unit} as scale")
    return remarks
