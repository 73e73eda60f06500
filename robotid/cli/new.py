"""The command new: a configuration to start from, with what can be guessed of one's own data."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import yaml

from robotid.cli.console import print_message, print_tables
from robotid.config.load import parse
from robotid.config.suggest import suggest
from robotid.config.template import measured, several, virtual
from robotid.errors import ConfigError, InputError, NumericsError
from robotid.files import atomic_write
from robotid.numerals import number
from robotid.report.tables.table import Table
from robotid.signals.columns import ALIASES, NEEDED, Column
from robotid.signals.correction import corrected
from robotid.signals.joining import joined
from robotid.signals.plausibility import Axis, check_records
from robotid.signals.proposal import Proposal, propose
from robotid.signals.proposed_time import GIVE_SAMPLING_TIME
from robotid.signals.quality import Recordings
from robotid.signals.readers import read
from robotid.signals.units import UNITS
from robotid.stages.ingestion.measured import measured_records

MAX_CORRECTIONS = 4  # of a proposal, one after another
SAY = "say which column is what by --column SIGNAL=NAME"
SLIDING = ("length", "speed", "force")


def write_configuration(
    name: str,
    data: Sequence[Path],
    chosen: Sequence[str] = (),
    scales: Sequence[str] = (),
    sampling_time: float | None = None,
    *,
    force: bool,
) -> None:
    """Write NAME.yaml. data : files of one recording, joined by time, or none; chosen : columns as SIGNAL=NAME;
    scales : SI units for one of a column, as SIGNAL=NUMBER; sampling_time [s] : of a file without a time column. A
    configuration that cannot run is not written.

    Raises ConfigError where it exists, InputError where data cannot be read, and what reading them by it raises.
    """
    path = Path(name) if name.endswith((".yaml", ".yml")) else Path(f"{name}.yaml")
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_-]*", path.stem):
        raise ConfigError(f'"{path.stem}" is no name', where="new", hint="use letters, digits, _ and - only")
    if path.exists() and not force:
        raise ConfigError("this file exists", where=str(path), hint="choose another NAME, or --force to overwrite it")
    if not data:
        atomic_write(path, virtual(path.stem, str(path)))
        print_message(f"{path} written: it runs as it is, on a virtual robot; replace its records by your own")
        return
    for file in data:
        if not file.exists():
            raise InputError("there is no such file", where=str(file), hint="give --from-data a recording")
        if not _is_text(file):
            raise InputError(
                "no configuration can name this file, its name is not UTF-8", where=str(file), hint="rename it"
            )
    found = _scaled(_asked(data, dict(map(_pair, chosen))), scales)
    if found.sampling_time is None and sampling_time is None:
        hint = "say how many seconds are between two samples, such as --sampling-time 0.001"
        what = next(one.partition(";")[0] for one in found.remarks if one.endswith(GIVE_SAMPLING_TIME))
        raise ConfigError(what, where=_named(data), hint=hint)
    found = _plausible(path, found, sampling_time)
    atomic_write(path, _configuration(path, found, sampling_time))
    print_tables([_guessed(found)])
    if found.axes:
        print_message(f"the file holds {len(found.axes)} axes: at the end of {path} is what describes all of them")
    print_message(f"{path} written: check its columns, then `robotid run {path}`")


def _is_text(path: Path) -> bool:
    """Whether a path from here is text, so that a configuration can name it."""
    try:
        os.path.relpath(path).encode()
    except UnicodeEncodeError:
        return False
    return True


def _pair(text: str) -> tuple[str, str]:
    """SIGNAL=NAME as a pair. Raises ConfigError for what is none."""
    signal, given, column = text.partition("=")
    if not given or not column:
        raise ConfigError(f'"{text}" is no SIGNAL=NAME', where="--column", hint="such as --column tau_m=Torque")
    if signal not in ALIASES:
        raise ConfigError(f'there is no signal "{signal}"', where="--column", hint=suggest(signal, ALIASES))
    return signal, column


def _named(files: Sequence[Path]) -> str:
    return " + ".join(map(str, files))


def _asked(data: Sequence[Path], chosen: dict[str, str]) -> Proposal:
    """What is proposed for a file; a person at a terminal is asked for the columns that nothing tells. Raises
    ConfigError where nobody can be asked."""
    found = propose(*data, chosen=chosen)
    for signal in (signal for signal in NEEDED if signal not in found.columns):
        if not sys.stdin.isatty():
            remark = next(remark for remark in found.remarks if f"looks like {signal}" in remark)
            what, _, holds = remark.partition("; ")
            hint = f"say which by --column {signal}=NAME; {holds}"
            raise ConfigError(what, where=_named(data), hint=hint)
        print_message(next(remark for remark in found.remarks if f"looks like {signal}" in remark))
        chosen = chosen | {signal: input(f"column of {signal}: ").strip()}
        found = propose(*data, chosen=chosen)
    return found


def _scaled(found: Proposal, scales: Sequence[str]) -> Proposal:
    """A proposal with scales that a person gives. Raises ConfigError for what is no scale of a column."""
    columns = dict(found.columns)
    for text in scales:
        signal, _, value = text.partition("=")
        try:
            scale = float(value)
        except ValueError:
            raise ConfigError(
                f'"{text}" is no SIGNAL=NUMBER', where="--scale", hint="such as --scale tau_m=0.12"
            ) from None
        if signal not in columns:
            raise ConfigError(f'there is no column of "{signal}"', where="--scale", hint=suggest(signal, columns))
        columns[signal] = replace(columns[signal], scale=scale)
    asked = tuple(f"{columns[text.partition('=')[0]].name} is in " for text in scales)
    remarks = tuple(one for one in found.remarks if not (asked and one.startswith(asked)))  # as has been done
    return replace(found, columns=columns, remarks=remarks)


def _plausible(path: Path, found: Proposal, sampling_time: float | None) -> Proposal:
    """A proposal whose record can be read and makes sense.

    Raises what reading it raises, and NumericsError for a finding that only a person can put right.
    """
    table = joined([read(path) for path in found.paths])
    for _ in range(MAX_CORRECTIONS):
        settings = parse(_configuration(path, found, sampling_time), name=str(path))
        made = measured_records(settings.records[0], table, linear=settings.robot.linear)
        recordings = Recordings(tuple(record for record, _ in made), tuple(report for _, report in made))
        checked = check_records(recordings, Axis(settings.robot.gear_ratio, settings.robot.linear))
        if checked:
            break
        other = corrected(found, recordings.records[0], checked.fatal[0])
        if other is None:
            break
        found = other
    if not checked:
        first = checked.fatal[0]
        signal = "phi_m" if first.name.startswith("angle") else "tau_m"
        hint = f"say how many SI units one is, --scale {signal}=NUMBER" if first.name == "angle_counts" else SAY
        raise NumericsError(f"{first.what}, so that {first.consequence}", where=_named(found.paths), hint=hint)
    return found


def _configuration(path: Path, found: Proposal, sampling_time: float | None) -> str:
    files = [Path(os.path.relpath(one, path.parent)).as_posix() for one in found.paths]
    file: str | list[str] = files if files[1:] else files[0]
    record = re.sub(r"[^A-Za-z0-9_-]+", "_", found.paths[0].stem)
    sliding = any(_quantity(column) in SLIDING for column in found.columns.values())
    text = measured(path.stem, str(path), _flow(file), record, _columns(found, sampling_time), linear=sliding)
    axes = [_flow({signal: _shortest(column) for signal, column in one.items()}) for one in found.axes]
    return text + several(path.stem, axes) if axes else text


def _columns(found: Proposal, sampling_time: float | None) -> str:
    """The columns block, and what a person should check as comments."""
    lines = [
        f"      {signal}: {_flow(_shortest(column))}{_to_edit(column)}" for signal, column in found.columns.items()
    ]
    lines += [f"      {signal}: null" for signal in found.left_out]
    head = ["    columns:                       # guessed: check them"] if lines else []
    step = found.sampling_time
    given = sampling_time is not None
    time = (
        f"    sampling_time: {sampling_time:g}           # in s"
        if given
        else f"    # the time column steps by {step:g} s"
    )
    return "\n".join([*head, *lines, time, *(f"    # {remark}" for remark in found.remarks)])


def _shortest(column: Column) -> str | dict[str, str | int | float]:
    """A column as shortly as the configuration allows."""
    entry: dict[str, str | int | float] = {"name": column.name}
    if column.column is not None:
        entry["column"] = column.column
    if column.unit is not None and (UNITS[column.unit].factor != 1.0 or column.scale is not None):
        entry["unit"] = column.unit
    if column.scale is not None:
        entry["scale"] = column.scale
    return entry if len(entry) > 1 else column.name


def _to_edit(column: Column) -> str:
    raw = column.unit is not None and UNITS[column.unit].raw
    return f"   # edit scale: how much SI is 1 {column.unit}" if raw and column.scale is not None else ""


def _quantity(column: Column) -> str:
    return "" if column.unit is None else UNITS[column.unit].quantity


def _flow(value: object) -> str:
    """A value as YAML on one line."""
    return (
        yaml.safe_dump(value, default_flow_style=True, width=10**6, sort_keys=False, allow_unicode=True)
        .removesuffix("\n...\n")
        .strip()
    )


def _guessed(found: Proposal) -> Table:
    rows = tuple(
        (signal, column.name, "-" if column.column is None else str(column.column), column.unit or "SI")
        for signal, column in found.columns.items()
    )
    step = f"the time column steps by {number(found.sampling_time, 6)} s"
    note = "\n".join((*([step] if found.sampling_time is not None else []), *found.remarks))
    return Table(f"Guessed of {_named(found.paths)}", ("signal", "column", "of a matrix", "unit"), rows, note)
