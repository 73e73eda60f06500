"""ASAM MDF files, version 3 and 4, by asammdf.

A channel goes by its name, and where several groups have one of that name, by group.name. Every group has its own time
stamps.
"""

from __future__ import annotations

import gc
import logging
from collections import Counter
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.extra import library
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import Table, numeric, table

SUFFIXES = (".mf4", ".mdf")


@dataclass(frozen=True, slots=True, eq=False)
class _Channel:
    """One channel of a group. samples : as physical values; is_time : of the group's time stamps."""

    group: str
    name: str
    unit: str
    samples: Any
    is_time: bool


def read(path: Path) -> Table:
    """Every numeric channel, with its unit. Samples that the file marks as invalid are nan.

    Raises InputError for a damaged file, for one that declares more than there is room for, and where asammdf is not
    installed.
    """
    asammdf = library("asammdf", "mdf", path)
    channels = _channels(asammdf, path)
    if channels is None:
        what = "this is not a readable MDF file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again")
    return _table(path, channels)


def _channels(asammdf: Any, path: Path) -> list[_Channel] | None:
    """All channels of a file, None where it is damaged.

    asammdf then talks to both streams, and once more when its remains are collected. Nobody needs to hear it.
    """
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        try:
            # by its path it would be opened for writing
            with path.open("rb") as opened, asammdf.MDF(opened) as file:
                for i, title in enumerate(_titles(file)):
                    require_room(path, title, _declared_size(file.groups[i].channel_group))
                return [channel for i, title in enumerate(_titles(file)) for channel in _group(file, i, title)]
        except InputError:
            raise
        except Exception:  # the parser fails in ways that nobody has listed
            pass
        gc.collect()
    return None


def _declared_size(group: Any) -> int:
    """Bytes of all records of a group, as its header declares."""
    marks = getattr(group, "invalidation_bytes_nr", 0) or 0
    return int(group.cycles_nr) * (int(group.samples_byte_nr) + int(marks))


def _titles(file: Any) -> list[str]:
    """Names of the groups: what they were acquired as, or their number where that is no name."""
    given = [getattr(group.channel_group, "acq_name", "") or "" for group in file.groups]
    count = Counter(given)
    return [title if title and count[title] == 1 else f"group{i}" for i, title in enumerate(given)]


def _group(file: Any, i: int, title: str) -> Iterator[_Channel]:
    """The channels of one group, read in one go."""
    group, time = file.groups[i], file.masters_db.get(i)
    if not group.channel_group.cycles_nr:
        return
    wanted = [(None, i, j) for j in range(len(group.channels))]
    for j, signal in enumerate(file.select(wanted, copy_master=False, ignore_value2text_conversions=True)):
        yield _Channel(title, signal.name, str(signal.unit or ""), _valid(signal), j == time)


def _valid(signal: Any) -> Any:
    """Samples, nan where they are marked as invalid."""
    marked, samples = signal.invalidation_bits, signal.samples
    if marked is None or samples.dtype.kind not in "fiub" or not np.any(marked):
        return samples
    samples = samples.astype(np.float64)
    samples[np.asarray(marked, dtype=np.bool_)] = np.nan
    return samples


def _table(path: Path, channels: list[_Channel]) -> Table:
    count = Counter(channel.name for channel in channels)
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    text: dict[str, str] = {}
    groups: dict[str, str] = {}
    for channel in channels:
        name = channel.name if count[channel.name] == 1 else f"{channel.group}.{channel.name}"
        for dotted, values in numeric(name, channel.samples):
            columns[dotted], groups[dotted] = values, channel.group
            units |= {dotted: channel.unit} if channel.unit not in ("", "-") else {}
        if channel.samples.dtype.kind in "SU" and len(channel.samples):
            first = channel.samples[0]
            text[name] = first.decode(errors="replace") if isinstance(first, bytes) else str(first)
    times = {c.group: c.name if count[c.name] == 1 else f"{c.group}.{c.name}" for c in channels if c.is_time}
    clocks = {name: times[group] for name, group in groups.items() if times.get(group) in columns}
    return table(str(path), columns, units, text=text, clocks=clocks)
