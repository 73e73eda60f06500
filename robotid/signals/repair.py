"""Flaws of a recording: mended aloud where they are few, refused in one line where they are not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table

FEW = 3  # samples in a row that are mended unasked
LARGEST_JITTER = 0.3  # of the sampling time, by which an interval may be off


@dataclass(frozen=True, slots=True)
class Policy:
    """What to do about each flaw: "refuse", the named repair, or None to mend a few and refuse many."""

    gaps: str | None = None
    nan: str | None = None
    duplicates: str | None = None
    wrap: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Mended:
    """Signals (n,) on a regular grid, and what was done to them. jitter : largest, as a share of the sampling time."""

    signals: dict[str, Array]
    sampling_time: float
    jitter: float
    missing: int
    duplicated: int
    not_finite: int
    wraps: int
    remarks: tuple[str, ...]


@dataclass(slots=True, eq=False)
class _Recording:
    """What is being mended. rows : of the table, one a sample; t : (n,) or None."""

    table: Table
    policy: Policy
    signals: dict[str, Array]
    t: Array | None
    rows: NDArray[np.intp]
    remarks: list[str] = field(default_factory=list)

    def where(self, k: int) -> str:
        return self.table.where(int(self.rows[k]))


def mend(
    table: Table,
    signals: Mapping[str, Array],
    t: Array | None,
    sampling_time: float | None,
    turn: Mapping[str, float],
    policy: Policy,
) -> Mended:
    """Signals as they should have been recorded. t : (n,) [s] or None; turn : angle of one wrap-around, by signal.

    Raises InputError where a flaw is refused.
    """
    recording = _Recording(table, policy, dict(signals), t, np.arange(len(next(iter(signals.values())))))
    not_finite = 0
    if recording.t is not None:
        recording.t, not_finite = _finite(recording, "t", recording.t)
    duplicated = _drop_duplicates(recording)
    # An angle is unwrapped before anything is interpolated: halfway through a wrap-around it never was.
    wraps = sum([_unwrap(recording, name, angle) for name, angle in turn.items() if name in signals])
    for name, values in recording.signals.items():
        recording.signals[name], count = _finite(recording, name, values)
        not_finite += count
    h = _period(recording, sampling_time)
    missing, jitter = _fill_gaps(recording, h)
    remarks = tuple(recording.remarks)
    return Mended(recording.signals, h, jitter, missing, duplicated, not_finite, wraps, remarks)


def _finite(recording: _Recording, name: str, values: Array) -> tuple[Array, int]:
    """A signal without what is not a number, and how much of that there was."""
    bad = ~np.isfinite(values)
    count = int(bad.sum())
    if not count:
        return values, 0
    where, longest, nan = recording.where(int(np.argmax(bad))), _longest_run(bad), recording.policy.nan
    what = f"{name} is not a number in {count} samples" + (f", {longest} of them in a row" if longest > 1 else "")
    if count > len(values) // 2:
        raise InputError(what, where=where, hint="record again, or name another column")
    if nan == "refuse" or (nan is None and longest > FEW):
        raise InputError(what, where=where, hint="record again, or set repair: {nan: interpolate}")
    good, at = np.flatnonzero(~bad), np.arange(len(values))
    recording.remarks.append(f"{name}: {count} samples that were not a number are interpolated, the first at {where}")
    return np.interp(at, good, values[good]), count


def _longest_run(mask: Array) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2]))


def _drop_duplicates(recording: _Recording) -> int:
    """Drop the samples that repeat the time before them; their number."""
    t, duplicates = recording.t, recording.policy.duplicates
    if t is None:
        return 0
    step = np.diff(t, prepend=-np.inf)
    if (step < 0).any():
        k = int(np.argmax(step < 0))
        what = f"time runs backward, from {t[k - 1]:.6g} to {t[k]:.6g} s"
        raise InputError(what, where=recording.where(k), hint="sort the recording, or cut it there")
    again = np.flatnonzero(step == 0)
    if not len(again):
        return 0
    same = all(np.array_equal(v[again], v[again - 1], equal_nan=True) for v in recording.signals.values())
    where = recording.where(int(again[0]))
    if duplicates == "refuse" or (duplicates is None and not same):
        what = f"{len(again)} samples repeat the time before them" + ("" if same else " with other values")
        raise InputError(what, where=where, hint="set repair: {duplicates: drop} to keep the first of each")
    recording.remarks.append(f"{len(again)} duplicated samples are dropped, the first at {where}")
    recording.t, recording.rows = np.delete(t, again), np.delete(recording.rows, again)
    recording.signals = {name: np.delete(v, again) for name, v in recording.signals.items()}
    return len(again)


def _unwrap(recording: _Recording, name: str, turn: float) -> int:
    """Unwrap an angle where it jumps by a turn now and then; the number of jumps."""
    angle = recording.signals[name].copy()
    good = np.flatnonzero(np.isfinite(angle))
    jump = np.abs(np.diff(angle[good]))
    wraps = np.flatnonzero((jump > 0.75 * turn) & (jump < 1.25 * turn))
    if not len(wraps) or float(np.percentile(jump, 90)) > 0.25 * turn:
        return 0
    where = recording.where(int(good[wraps[0] + 1]))
    if recording.policy.wrap == "refuse":
        raise InputError(f"{name} wraps around", where=where, hint="set repair: {wrap: unwrap}")
    angle[good] = np.unwrap(angle[good], period=turn)
    recording.signals[name] = angle
    recording.remarks.append(f"{name}: {len(wraps)} wrap-arounds are unwrapped, the first at {where}")
    return len(wraps)


def _period(recording: _Recording, declared: float | None) -> float:
    """Sampling time, from the time column or as declared. Raises InputError where the two differ by 1 %."""
    if recording.t is None:
        assert declared is not None
        return declared
    if len(recording.t) < 2:
        raise InputError("there is a single sample", where=recording.table.path, hint="record longer")
    h = usual_step(recording.t)
    if declared is not None and abs(h - declared) > 0.01 * declared:
        what = f"samples are {h:.6g} s apart, sampling_time says {declared:.6g} s"
        raise InputError(what, where=recording.table.path, hint="give the time column's unit, or mend sampling_time")
    return declared or h


def usual_step(t: Array) -> float:
    """Sampling time of increasing times (n,), gaps left out; a round number where one is as good."""
    steps = np.diff(t)
    usual = float(np.median(steps))
    h = float(np.mean(steps[np.abs(steps - usual) <= 0.5 * usual]))
    round_numbers = (float(f"{h:.{digits}g}") for digits in range(1, 7))
    return next((r for r in round_numbers if abs(r - h) * len(steps) < 0.5 * h), h)


def _fill_gaps(recording: _Recording, h: float) -> tuple[int, float]:
    """Interpolate missing samples; their number and the largest jitter."""
    if recording.t is None:
        return 0, 0.0
    steps = np.diff(recording.t)
    counts = np.maximum(1, np.rint(steps / h)).astype(int)
    jitter, longest = np.abs(steps / h - counts), int(np.argmax(counts))
    if jitter.max() > LARGEST_JITTER:
        k = int(np.argmax(jitter > LARGEST_JITTER))
        what = f"sampling is irregular: {steps[k]:.6g} s where {h:.6g} s are usual"
        raise InputError(what, where=recording.where(k + 1), hint="record at a fixed rate, or resample")
    missing, gaps = int((counts - 1).sum()), recording.policy.gaps
    if not missing:
        return 0, float(jitter.max())
    if gaps == "refuse" or (gaps is None and counts[longest] - 1 > FEW):
        what = f"{missing} samples are missing, {counts[longest] - 1} of them in a row"
        hint = "cut the record there, or set repair: {gaps: interpolate}"
        raise InputError(what, where=recording.where(longest + 1), hint=hint)
    first = recording.where(int(np.argmax(counts > 1)) + 1)
    recording.remarks.append(f"{missing} missing samples are interpolated, the first before {first}")
    at = np.concatenate([[0], np.cumsum(counts)])
    recording.signals = {name: np.interp(np.arange(at[-1] + 1), at, v) for name, v in recording.signals.items()}
    return missing, float(jitter.max())
