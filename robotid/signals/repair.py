"""Flaws of a recording: mended aloud where they are few, refused in one line where they are not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table
from robotid.signals.sampling import Grid, Policy, distinct, few, longest_run, regular

FARTHEST_STEP = 0.4  # of a turn; half a turn between samples could be either way


@dataclass(frozen=True, slots=True, eq=False)
class Mended:
    """Signals (n,) on a regular grid, and what was done to them. jitter, jitter_rms : largest and root mean square
    deviation of a sampling interval, shares of the sampling time."""

    signals: dict[str, Array]
    sampling_time: float
    jitter: float
    jitter_rms: float
    missing: int
    duplicated: int
    not_finite: int
    wraps: int
    remarks: tuple[str, ...]


def mend(
    table: Table,
    signals: Mapping[str, Array],
    rows: Array,
    t: Array | None,
    sampling_time: float | None,
    turns: Mapping[str, tuple[float, ...]],
    policy: Policy,
) -> Mended:
    """Signals as they should have been recorded.

    rows : (n,) of the table, for messages; t : (n,) [s] or None; turns : angles at which a signal may wrap around.
    Raises InputError where a flaw is refused.
    """
    remarks: list[str] = []
    grid, found = Grid(1.0 if sampling_time is None else sampling_time, rows), dict(signals)
    lost, bad = 0, 0
    if t is not None:
        t, bad = finite(table, "t", t, rows, policy, remarks)
        keep = distinct(table, t, found, rows, policy, remarks)
        t, rows, found = t[keep], rows[keep], {name: values[keep] for name, values in found.items()}
        lost = int(len(keep) - keep.sum())
        grid = regular(table, t, rows, sampling_time, policy, remarks)
    wraps = 0
    for name, values in found.items():
        unwrapped, count = unwrap(table, name, values, rows, turns.get(name, ()), policy, remarks)
        continuous, holes = finite(table, name, unwrapped, rows, policy, remarks)
        found[name] = grid.fill(continuous)
        wraps, bad = wraps + count, bad + holes
    return Mended(
        found, grid.sampling_time, grid.jitter, grid.jitter_rms, grid.missing, lost, bad, wraps, tuple(remarks)
    )


def finite(
    table: Table, name: str, values: Array, rows: Array, policy: Policy, remarks: list[str]
) -> tuple[Array, int]:
    """A signal without NaN and infinity, (n,), and how many there were."""
    bad = ~np.isfinite(values)
    count = int(bad.sum())
    if not count:
        return values, 0
    where, longest = table.where(int(rows[np.argmax(bad)])), longest_run(bad)
    if count > len(values) // 2:
        what = f"{name} is not a number in {count} of {len(values)} samples"
        raise InputError(what, where=where, hint="record again, or name another column")
    if policy.nan == "refuse" or (policy.nan is None and not few(count, longest, len(values))):
        row = f" samples, {longest} of them in a row" if longest > 1 else " samples" if count > 1 else " sample"
        what = f"{name} is not a number in {count}{row}"
        raise InputError(what, where=where, hint="record again, or set repair: {nan: interpolate}")
    good = np.flatnonzero(~bad)
    plural = f"{count} samples that were not numbers are" if count > 1 else "1 sample that was not a number is"
    remarks.append(f"{name}: {plural} interpolated, the first at {where}")
    return np.interp(np.arange(len(values)), good, values[good]), count


def unwrap(
    table: Table, name: str, values: Array, rows: Array, turns: tuple[float, ...], policy: Policy, remarks: list[str]
) -> tuple[Array, int]:
    """An angle that does not jump by a turn, (n,), and how often it did. nan stays."""
    good = np.flatnonzero(np.isfinite(values))
    known = values[good]
    jump = np.abs(np.diff(known))
    turn = next((turn for turn in turns if wraps_at(turn, known)), None)
    if turn is None:
        return values, 0
    wraps = jump > 0.5 * turn
    where = table.where(int(rows[good[np.argmax(wraps) + 1]]))
    if float(np.minimum(jump, np.abs(turn - jump)).max()) > FARTHEST_STEP * turn:
        hint = "record faster, or record an angle that does not wrap around"
        raise InputError(f"{name} turns too far between samples to be unwrapped", where=where, hint=hint)
    if policy.wrap == "refuse":
        raise InputError(f"{name} wraps around", where=where, hint="set repair: {wrap: unwrap}")
    count = int(wraps.sum())
    plural = f"{count} wrap-arounds are" if count > 1 else "1 wrap-around is"
    remarks.append(f"{name}: {plural} unwrapped, the first at {where}")
    continuous = values.copy()
    continuous[good] = np.unwrap(known, period=turn)
    return continuous, count


def wraps_at(turn: float, angle: Array) -> bool:
    """Whether an angle stays within one turn and jumps by nearly that, from edge to edge. angle : (n,)."""
    jump = np.abs(np.diff(angle))
    wraps = jump > 0.75 * turn
    if not wraps.any() or float(np.ptp(angle)) > 1.01 * turn or wraps.all():
        return False
    usual = float(np.percentile(jump[~wraps], 99))
    return float(np.abs(turn - jump[wraps]).max()) <= max(4 * usual, 1e-3 * turn)
