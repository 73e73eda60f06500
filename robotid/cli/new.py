"""The command new: a configuration to start from, with what can be guessed of one's own data."""

from __future__ import annotations

import os
import re
from pathlib import Path

import yaml

from robotid.cli.console import print_message, print_tables
from robotid.config.template import measured, virtual
from robotid.errors import ConfigError, InputError
from robotid.files import atomic_write
from robotid.report.numbers import number
from robotid.report.tables.table import Table
from robotid.signals.columns import Column
from robotid.signals.proposal import Proposal, propose
from robotid.signals.units import UNITS

SLIDING = ("length", "speed", "force")


def write_configuration(name: str, data: Path | None, *, force: bool) -> None:
    """Write NAME.yaml. Raises ConfigError where it exists, InputError where data cannot be read."""
    path = Path(name) if name.endswith((".yaml", ".yml")) else Path(f"{name}.yaml")
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_-]*", path.stem):
        raise ConfigError(f'"{path.stem}" is no name', where="new", hint="use letters, digits, _ and - only")
    if path.exists() and not force:
        raise ConfigError("this file exists", where=str(path), hint="choose another NAME, or --force to overwrite it")
    if data is None:
        atomic_write(path, virtual(path.stem, str(path)))
        print_message(f"{path} written: it runs as it is, on a virtual robot; replace its records by your own")
        return
    if not data.is_file():
        raise InputError("there is no such file", where=str(data), hint="give --from-data a recording")
    found = propose(data)
    atomic_write(path, _configuration(path, found))
    print_tables([_guessed(found)])
    print_message(f"{path} written: check its columns, then `robotid run {path}`")


def _configuration(path: Path, found: Proposal) -> str:
    file = Path(os.path.relpath(found.path, path.parent)).as_posix()
    record = re.sub(r"[^A-Za-z0-9_-]+", "_", found.path.stem)
    sliding = any(_quantity(column) in SLIDING for column in found.columns.values())
    return measured(path.stem, str(path), _flow(file), record, _columns(found), linear=sliding)


def _columns(found: Proposal) -> str:
    """The columns block, and what a person should look at as comments."""
    lines = [
        f"      {signal}: {_flow(_shortest(column))}{_to_edit(column)}" for signal, column in found.columns.items()
    ]
    head = ["    columns:                       # guessed: check them"] if lines else []
    step = found.sampling_time
    time = (
        f"    # the time column steps by {step:g} s"
        if step is not None
        else "    # sampling_time: 0.001         # in s"
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
    return f"   # edit scale: how much SI is 1 {column.unit}" if column.scale is not None else ""


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
    return Table(f"Guessed of {found.path}", ("signal", "column", "of a matrix", "unit"), rows, note)
