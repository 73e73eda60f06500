"""Flaws of a recording: mended aloud where they are few, refused in one line where they are not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table

FEW = 3  # samples in a row that are mended unasked
LARGEST_JITTER = 0.3  # of the sampling time, by which a sample may be off the grid


@dataclass(frozen=True, slots=True)
class Policy:
    """What to do about each flaw: "refuse", the named repair, or None to mend a few and refuse many."""

    gaps: str | None = None
    nan: str | None = None
    duplicates: str | None = None
    wrap: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Mended:
    """Signals (n,) on a regular grid, and what was done to them."""

    signals: dict[str, Array]
    sampling_time: float
    jitter: float
    missing: int
    duplicated: int
    not_finite: int
    wraps: int
    remarks: tuple[str, ...]


def mend(
    table: Table, signals: Mapping[str, Array], t: Array | None, sampling_time: float | None, turn: Mapping[str, float], policy: Policy
) -> Mended:
    """Signals as they should have been recorded. t : (n,) [s] or None; turn : angle of one wrap-around, by signal.

    Raises InputError where a flaw is refused.
    """
    remarks: list[str] = []
    rows = np.arange(len(next(iter(signals.values()))))
    found = dict(signals) if t is None else {**signals, "t": t}
    found, bad = _finite(table, found, policy, remarks)
    time = found.pop("t", None)
    missing = duplicated = 0
    jitter = 0.0
    if time is None:
        assert sampling_time is not None
        h = sampling_time
    else:
        keep = _distinct(table, time, found, policy, remarks)
        duplicated = int(len(keep) - keep.sum())
        time, rows, found = time[keep], rows[keep], {k: v[keep] for k, v in found.items()}
        h = _period(table, time, rows, sampling_time)
        missing, jitter, found = _regular(table, time, rows, h, found, policy, remarks)
    found, wraps = _unwrapped(table, found, turn, policy, remarks)
    return Mended(found, h, jitter, missing, duplicated, bad, wraps, tuple(remarks))


def _finite(table: Table, signals: dict[str, Array], policy: Policy, remarks: list[str]) -> tuple[dict[str, Array], int]:
    total = 0
    for name, values in signals.items():
        bad = ~np.isfinite(values)
        count = int(bad.sum())
        if not count:
            continue
        first, longest = int(np.argmax(bad)), _longest_run(bad)
        if policy.nan == "refuse" or (policy.nan is None and longest > FEW) or count > len(values) // 2:
            what = f"{name} is not a number in {count} samples, {longest} in a row"
            raise InputError(what, where=table.where(first), hint="record again, or set repair: {nan: interpolate}")
        good = np.flatnonzero(~bad)
        signals = {**signals, name: np.interp(np.arange(len(values)), good, values[good])}
        remarks.append(f"{name}: {count} samples that were not a number are interpolated, the first at {table.where(first)}")
        total += count
    return signals, total


def _longest_run(mask: Array) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2]))


def _distinct(table: Table, t: Array, signals: Mapping[str, Array], policy: Policy, remarks: list[str]) -> Array:
    """Samples to keep, (n,) bool."""
    step = np.diff(t)
    if (step < 0).any():
        k = int(np.argmax(step < 0))
        what = f"time runs backward, from {t[k]:.6g} to {t[k + 1]:.6g} s"
        raise InputError(what, where=table.where(k + 1), hint="sort the recording, or cut it there")
    again = np.concatenate([[False], step == 0])
    if again.any():
        k = int(np.argmax(again))
        same = all(np.array_equal(v[again], v[:-1][again[1:]]) for v in signals.values())
        if policy.duplicates == "refuse" or (policy.duplicates is None and not same):
            what = f"{int(again.sum())} samples repeat the time before them" + ("" if same else " with other values")
            raise InputError(what, where=table.where(k), hint="set repair: {duplicates: drop} to keep the first of each")
        remarks.append(f"{int(again.sum())} duplicated samples are dropped, the first at {table.where(k)}")
    return np.asarray(~again)


def _period(table: Table, t: Array, rows: Array, declared: float | None) -> float:
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if step <= 0:
        raise InputError("there are no samples at different times", where=table.path, hint="check the time column")
    regular = np.flatnonzero(np.abs(np.diff(t) - step) < 0.5 * step)
    h = float(np.mean(np.diff(t)[regular])) if len(regular) else step
    h = float(f"{h:.6g}") if abs(float(f"{h:.6g}") - h) < 1e-4 * h else h
    if declared is not None and abs(h - declared) > 0.01 * declared:
        what = f"samples are {h:.6g} s apart, sampling_time says {declared:.6g} s"
        raise InputError(what, where=table.path, hint="give the unit of the time column, or mend sampling_time")
    return declared or h


def _regular(
    table: Table, t: Array, rows: Array, h: float, signals: dict[str, Array], policy: Policy, remarks: list[str]
) -> tuple[int, float, dict[str, Array]]:
    """Missing samples, largest jitter as a share of the sampling time, and the signals with gaps filled."""
    steps = np.maximum(1, np.rint(np.diff(t) / h)).astype(int)
    offset = np.diff(t) / h - steps
    jitter = float(np.abs(offset).max()) if len(offset) else 0.0
    if jitter > LARGEST_JITTER:
        k = int(np.argmax(np.abs(offset)))
        what = f"sampling is irregular: {t[k + 1] - t[k]:.6g} s where {h:.6g} s are usual"
        raise InputError(what, where=table.where(int(rows[k + 1])), hint="record at a fixed rate, or resample")
    missing = int((steps - 1).sum())
    if not missing:
        return 0, jitter, signals
    k = int(np.argmax(steps > 1))
    if policy.gaps == "refuse" or (policy.gaps is None and int(steps.max()) - 1 > FEW):
        longest = int(np.argmax(steps))
        what = f"{missing} samples are missing, {int(steps.max()) - 1} of them in a row"
        hint = "cut the record there, or set repair: {gaps: interpolate}"
        raise InputError(what, where=table.where(int(rows[longest + 1])), hint=hint)
    at = np.concatenate([[0], np.cumsum(steps)])
    grid = np.arange(at[-1] + 1)
    remarks.append(f"{missing} missing samples are interpolated, the first before {table.where(int(rows[k + 1]))}")
    return missing, jitter, {name: np.interp(grid, at, v) for name, v in signals.items()}


def _unwrapped(
    table: Table, signals: dict[str, Array], turn: Mapping[str, float], policy: Policy, remarks: list[str]
) -> tuple[dict[str, Array], int]:
    total = 0
    for name, angle in turn.items():
        if name not in signals or len(signals[name]) < 3:
            continue
        jump = np.abs(np.diff(signals[name]))
        wraps = (jump > 0.75 * angle) & (jump < 1.25 * angle)
        if not wraps.any() or float(np.percentile(jump, 90)) > 0.25 * angle:
            continue
        k = int(np.argmax(wraps))
        if policy.wrap == "refuse":
            raise InputError(f"{name} wraps around", where=table.where(k + 1), hint="set repair: {wrap: unwrap}")
        signals = {**signals, name: np.unwrap(signals[name], period=angle)}
        remarks.append(f"{name}: {int(wraps.sum())} wrap-arounds are unwrapped, the first at {table.where(k + 1)}")
        total += int(wraps.sum())
    return signals, total
