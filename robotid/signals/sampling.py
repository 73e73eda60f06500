"""The time axis of a recording: one step, no sample twice, none missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotid.errors import InputError
from robotid.model.array import Array, Mask
from robotid.signals.readers.table import Table

MAX_RUN = 3  # samples in a row that are repaired unasked
MAX_SHARE = 0.01  # share of all samples that is repaired unasked
MAX_JITTER = 0.3  # of the sampling time, by which a step may deviate
COARSE = 0.1  # share of repeated times from which the time is written with too few digits


@dataclass(frozen=True, slots=True)
class Policy:
    """What to do about each flaw: "refuse", the named repair, or None to repair a few and refuse many."""

    gaps: str | None = None
    nan: str | None = None
    duplicates: str | None = None
    wrap: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """Where flaws are, what to do about them, and what was said. rows : (n,) of the table, one a sample."""

    table: Table
    policy: Policy
    rows: NDArray[np.intp]
    remarks: list[str] = field(default_factory=list)

    def where(self, k: int) -> str:
        """A sample as a place in the file."""
        return self.table.where(int(self.rows[k]))


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Where the samples stand on a regular grid.

    at : (n,) their numbers, counted from 0; jitter, jitter_rms : largest and root mean square deviation of a step, as
    shares of the sampling time; missing : samples in gaps.
    """

    sampling_time: float
    at: Array
    jitter: float = 0.0
    jitter_rms: float = 0.0
    missing: int = 0

    def fill(self, signal: Array) -> Array:
        """A signal with its missing samples interpolated, (n,) -> (n + missing,)."""
        return np.interp(np.arange(self.at[-1] + 1), self.at, signal) if self.missing else signal


def few(count: int, longest: int, n: int) -> bool:
    """Whether so many flaws of n samples, at most so many in a row, are repaired unasked."""
    return longest <= MAX_RUN and count <= max(MAX_RUN, MAX_SHARE * n)


def longest_run(mask: Mask) -> int:
    """Most consecutive True, at least one of them. mask : (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2]))


def distinct(found: Findings, t: Array, signals: Mapping[str, Array]) -> Mask:
    """Samples to keep, (n,): the first of each time.

    Raises InputError where time runs backward, or repeats with other values.
    """
    step = np.diff(t)
    if (step < 0).any():
        k = int(np.argmax(step < 0))
        what = f"time runs backward, from {t[k]:.6g} to {t[k + 1]:.6g} s"
        hint = "sort the recording, or cut it there by start or stop"
        raise InputError(what, where=found.where(k + 1), hint=hint)
    again = np.concatenate([[False], step == 0])
    count = int(again.sum())
    if not count:
        return ~again
    where = found.where(int(np.argmax(again)))
    same = all(np.array_equal(v[again], v[:-1][again[1:]], equal_nan=True) for v in signals.values())
    plural = f"{count} samples repeat" if count > 1 else "1 sample repeats"
    if found.policy.duplicates is None and not same and count > COARSE * len(t):
        what = f"{plural} the time before them with other values: time is written with too few digits"
        raise InputError(what, where=where, hint="write t: null under columns and give sampling_time instead")
    if found.policy.duplicates == "refuse" or (found.policy.duplicates is None and not same):
        what = f"{plural} the time before {'them' if count > 1 else 'it'}" + ("" if same else " with other values")
        raise InputError(what, where=where, hint="set repair: {duplicates: drop} to keep the first of each")
    dropped = f"{count} duplicated samples are" if count > 1 else "1 duplicated sample is"
    found.remarks.append(f"{dropped} dropped, the first at {where}")
    return ~again


def regular(found: Findings, t: Array, declared: float | None) -> Grid:
    """The grid that samples at increasing times stand on. Raises InputError for irregular sampling and long gaps."""
    h = _period(found, t, declared)
    steps = np.diff(t) / h
    counts = np.maximum(1, np.rint(steps)).astype(int)
    off = steps - counts
    if float(np.abs(off).max()) > MAX_JITTER:
        k = int(np.argmax(np.abs(off)))
        what = f"sampling is irregular: {t[k + 1] - t[k]:.6g} s where {h:.6g} s are usual"
        hint = "record at a fixed rate, or if only the clock is at fault write t: null and sampling_time"
        raise InputError(what, where=found.where(k + 1), hint=hint)
    missing = int((counts - 1).sum())
    if missing:
        _bridge(found, counts, missing)
    at = np.concatenate([[0], np.cumsum(counts)]).astype(np.float64)
    return Grid(h, at, float(np.abs(off).max()), float(np.sqrt(np.mean(off**2))), missing)


def usual_step(t: Array) -> float:
    """Sampling time [s] of increasing times (n,), gaps left out; a round number where one is as good."""
    steps = np.diff(t)
    usual = float(np.median(steps))
    h = float(np.mean(steps[np.abs(steps - usual) <= 0.5 * usual]))
    round_numbers = (float(f"{h:.{digits}g}") for digits in range(1, 7))
    return next((r for r in round_numbers if abs(r - h) * len(steps) < 0.5 * h), h)


def _period(found: Findings, t: Array, declared: float | None) -> float:
    if len(t) < 2:
        raise InputError("there is a single sample", where=found.table.path, hint="record longer")
    h = usual_step(t)
    if declared is not None and abs(h - declared) > 0.01 * declared:
        what = f"samples are {h:.6g} s apart, sampling_time says {declared:.6g} s"
        raise InputError(what, where=found.table.path, hint="give the time column's unit, or mend sampling_time")
    return declared or h


def _bridge(found: Findings, counts: NDArray[np.intp], missing: int) -> None:
    """Say that gaps are filled, or refuse."""
    longest = int(counts.max()) - 1
    repaired = found.policy.gaps is None and few(missing, longest, int(counts.sum()) + 1)
    refused = found.policy.gaps != "interpolate" and not repaired
    k = int(np.argmax(counts) if refused else np.argmax(counts > 1)) + 1
    where = found.where(k)
    plural = f"{missing} samples are missing" if missing > 1 else "1 sample is missing"
    if refused:
        hint = "cut the record there by start or stop, or set repair: {gaps: interpolate}"
        which = " before this one" if longest == missing else f", {longest} of them before this one"
        raise InputError(plural + which, where=where, hint=hint)
    found.remarks.append(f"{plural} and interpolated, the first before {where}")
