"""The time axis of a recording: one step, no sample twice, none missing.

Stamps that a regular clock explains are only counted. All others are positions, and the signals are brought from them
onto a regular grid; where the record stands still for longer than can be bridged, it is cut.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robotid.errors import InputError
from robotid.model.array import Array, Mask
from robotid.numerals import plain
from robotid.signals.readers.table import Table
from robotid.signals.resampling import MIN_TO_COMPARE, grid_positions, resample, sampled_regularly
from robotid.signals.torque_steps import TorqueSteps, torque_steps

MAX_RUN = 3  # samples in a row that are repaired unasked
MAX_SHARE = 0.01  # share of all samples that is repaired unasked
NOTABLE_JITTER = 1e-3  # of the sampling time, root mean square, from which signals are resampled on their stamps
IRREGULAR = 0.2  # of the sampling time, root mean square, from which steps are no multiples of it: nothing is missing
MAX_MISSING = 0.5  # share of all samples that may be missing between the others
ROUNDED = 0.6  # of the resolution of time stamps, up to which a regular clock is only written with few digits
COARSE = 0.1  # share of repeated times from which the time is written with too few digits
ALIKE = 0.25  # of an interval, within which another counts as the same
MAX_LOST = 0.45  # share of a clock's samples that are missing, up to which it is a clock that has lost samples
WHOLE = 0.1  # of the shortest interval, within which others are multiples of it
LONGEST_PATTERN = 64  # intervals after which they repeat
MOSTLY = 0.9  # share of the intervals that a clock, or a pattern of intervals, explains
MOST_DIGITS = 9  # of a time stamp [s] behind the point that are looked for
HELD = ("tau_m", "disturbance")  # signals that last from their sample to the next


@dataclass(frozen=True, slots=True)
class Policy:
    """What to do about each flaw: "refuse", the named repair, or None to repair a few and refuse many."""

    gaps: str | None = None
    nan: str | None = None
    duplicates: str | None = None
    wrap: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """Where flaws are, what to do about them, and the remarks. rows : (n,) of the table, one a sample."""

    table: Table
    policy: Policy
    rows: NDArray[np.intp]
    remarks: list[str] = field(default_factory=list)

    def where(self, k: int) -> str:
        """A sample as a place in the file."""
        return self.table.where(int(self.rows[k]))


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Where the samples stand on a regular grid, in sampling times.

    at : (n,) positions counted from the first sample, whole numbers for a regular clock; numbers : (n,) the whole
    numbers nearest to it as they follow each other; jitter, jitter_rms : largest and root mean square deviation of a
    step, as shares of the sampling time; late : (n,) [s] of each stamp against a regular clock; missing : samples in
    gaps; resolution [s] : of the stamps as they are written; resampled : the signals are interpolated at their
    positions.
    """

    sampling_time: float
    at: Array
    jitter: float = 0.0
    jitter_rms: float = 0.0
    missing: int = 0
    numbers: Array = field(default_factory=lambda: np.zeros(0))
    late: Array = field(default_factory=lambda: np.zeros(0))
    resolution: float = 0.0
    resampled: bool = False

    def settled(self, angle: Array) -> Grid:
        """The grid without its stamps, where the angle (n,) says that not the sampling jitters but the stamps."""
        if self.resampled and len(angle) > MIN_TO_COMPARE and sampled_regularly(self.at, self.numbers, angle):
            return replace(self, at=self.numbers, missing=int(self.numbers[-1]) + 1 - len(angle), resampled=False)
        return self

    def fill(self, signals: Mapping[str, Array]) -> dict[str, Array]:
        """Signals on the regular grid, (n,) -> (m,) each, gaps interpolated."""
        if self.resampled:
            return resample(self.at, signals, HELD, self._without_gaps)
        if not self.missing:
            return dict(signals)
        return {name: np.interp(self._without_gaps, self.at, signal) for name, signal in signals.items()}

    def torque_steps(self, torque: Array) -> TorqueSteps | None:
        """How a torque (n,) at its stamps changes within the intervals of the regular grid; None where it does not."""
        if not self.resampled:
            return None
        stamps = self._without_gaps
        return torque_steps(stamps, np.interp(stamps, self.at, torque), grid_positions(self.at))

    @property
    def _without_gaps(self) -> Array:
        """The stamps with those of the samples that are missing, evenly spaced within each gap, (n + missing,): a
        torque that had lasted over a gap would be wrong by all that it changed there."""
        if not self.missing:
            return self.at
        return np.interp(np.arange(self.numbers[-1] + 1), self.numbers, self.at)


def few(count: int, longest: int, n: int) -> bool:
    """Whether so many flaws of n samples, at most so many in a row, are repaired unasked."""
    return longest <= MAX_RUN and count <= max(MAX_RUN, MAX_SHARE * n)


def longest_run(mask: Mask) -> int:
    """Most consecutive True, at least one of them. mask : (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2]))


def in_order(found: Findings, t: Array, angle: Array) -> NDArray[np.intp]:
    """The rows in the order of their times, where a few samples were written late. t, angle : of the whole table, (n,).

    Rows stay as they are where more than a few are out of order, or the angle is not smoother for it: then the clock
    was set back.
    """
    rows = found.rows
    count = int(np.sum(np.diff(t[rows]) < 0))
    if not count or not np.isfinite(t[rows]).all():
        return rows
    order = np.argsort(t[rows], kind="stable")
    furthest = int(np.abs(order - np.arange(len(rows))).max(initial=0))
    if not few(count, furthest, len(rows)):
        return rows
    roughness = [float(np.nansum(np.diff(angle[one], 2) ** 2)) for one in (rows[order], rows)]
    if roughness[0] >= roughness[1]:
        return rows
    plural = f"{count} samples stood out of order and were" if count > 1 else "1 sample stood out of order and was"
    where = found.where(int(np.argmax(np.diff(t[rows]) < 0)) + 1)
    found.remarks.append(f"{plural} moved in time, the first at {where}")
    return rows[order]


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
    """The grid that samples at increasing times (n,) stand on. Raises InputError for gaps that cannot be bridged."""
    h = _period(found, t, declared)
    steps = np.diff(t) / h
    pattern = repeats_after(np.diff(t)) if found.policy.gaps is None else 0
    counts = np.maximum(1, np.rint(steps)).astype(int)
    if pattern:  # samples come in groups, and none is missing
        counts = np.ones(len(steps), dtype=int)
    off = steps - counts
    numbers = np.concatenate([[0], np.cumsum(counts)]).astype(np.float64)
    late = _late(t, numbers)
    resolution = stamp_resolution(t)
    jitter, jitter_rms = float(np.abs(off).max()), float(np.sqrt(np.mean(off**2)))
    rounded = float(np.abs(late).max()) <= ROUNDED * resolution
    if pattern:  # of a clock that is written with few digits, two intervals differ by one of these
        rounded = h * float(np.ptp(steps)) < 1.5 * resolution
        if not rounded:
            what = f"the sampling intervals repeat after {pattern}, from {plain(1e3 * h * steps.min())} to"
            found.remarks.append(f"{what} {plain(1e3 * h * steps.max())} ms: their mean is the sampling time")
    resampled = float(np.std(late)) > NOTABLE_JITTER * h and not rounded
    missing = int(numbers[-1]) + 1 - len(t)
    if resampled:  # long steps may make up for short ones
        missing = max(0, min(missing, round((t[-1] - t[0]) / usual_step(t, grouped=False)) + 1 - len(t)))
    if resampled and found.policy.gaps is None and jitter_rms > IRREGULAR and counts.max() <= MAX_RUN + 2:
        missing = 0
    if missing:
        _bridge(found, counts, missing)
    at = (t - t[0]) / h if resampled else numbers
    return Grid(h, at, jitter, jitter_rms, missing, numbers, late, resolution, resampled)


def _late(t: Array, numbers: Array) -> Array:
    """By how much each stamp is late against the regular clock that explains them best [s], (n,)."""
    x = numbers - numbers.mean()
    slope = float(x @ (t - t.mean())) / max(float(x @ x), 1e-300)
    return np.asarray(t - t.mean() - slope * x)


def stamp_resolution(t: Array) -> float:
    """The decimal fraction of a second that all stamps (n,) are multiples of, 0.0 where there is none."""
    for digits in range(MOST_DIGITS + 1):
        scaled = (t - t[0]) * 10.0**digits
        if float(np.abs(scaled - np.rint(scaled)).max()) < 1e-3:
            return float(10.0**-digits)
    return 0.0


def uninterrupted(found: Findings, t: Array) -> tuple[tuple[int, int], ...]:
    """First and last + 1 sample of each part between gaps that are too long to be bridged. t : (n,), nan where a stamp
    is missing.

    One part where the policy has gaps interpolated or refused, and where time runs backward.
    """
    known = np.flatnonzero(np.isfinite(t))
    steps = np.diff(t[known])
    if found.policy.gaps is not None or len(known) < 3 or (steps < 0).any() or not (steps > 0).any():
        return ((0, len(t)),)
    moving = steps[steps > 0]
    longest = (MAX_RUN + 1.5) * usual_step(np.concatenate([[0.0], np.cumsum(moving)]))
    pattern = repeats_after(moving)
    if pattern:
        longest = max(longest, 2.0 * float(np.median(np.sort(moving)[-(len(moving) // pattern) :])))
    cuts = known[1:][steps > longest]
    edges = [0, *cuts.tolist(), len(t)]
    return tuple(pairwise(edges))


def repeats_after(steps: Array) -> int:
    """After how many intervals (n,) they repeat, where they come in a pattern such as short and long ones in turn, or
    bursts of samples; 0 for a clock, and for intervals that follow no pattern."""
    usual = float(np.median(steps))
    other = np.flatnonzero(np.abs(steps - usual) > ALIKE * usual)
    if not len(other) or float(steps[other].sum()) < (1.0 - MOSTLY) * float(steps.sum()):
        return 0
    shortest = float(np.quantile(steps, 1.0 - MOSTLY))
    if shortest <= 0.0:
        return 0
    multiples = steps / shortest
    whole = float(np.mean(np.abs(multiples - np.rint(multiples)) <= WHOLE)) >= MOSTLY
    if whole and len(steps) > (1.0 - MAX_LOST) * float(multiples.sum()):
        return 0  # a clock that has lost samples, in a pattern or not
    for period in range(2, min(LONGEST_PATTERN, len(steps) // 4) + 1):
        first = other[other < len(steps) - period]
        near = ALIKE * np.maximum(steps[first], usual)
        if len(first) and float(np.mean(np.abs(steps[first + period] - steps[first]) <= near)) >= MOSTLY:
            return period
    return 0


def usual_step(t: Array, *, grouped: bool = True) -> float:
    """Sampling time [s] of increasing times (n,), gaps left out; a round number where one is as good. grouped : samples
    may come in groups, and of intervals that repeat in a pattern, it is the mean of this."""
    steps = np.diff(t)
    usual = float(np.median(steps))
    pattern = repeats_after(steps) if grouped else 0
    whole = steps[: len(steps) // pattern * pattern] if pattern else steps[np.abs(steps - usual) <= 0.5 * usual]
    h = float(np.mean(whole))
    round_numbers = (float(f"{h:.{digits}g}") for digits in range(1, 7))
    return next((r for r in round_numbers if abs(r - h) * len(steps) < 0.5 * h), h)


def _period(found: Findings, t: Array, declared: float | None) -> float:
    if len(t) < 2:
        raise InputError("there is a single sample", where=found.table.path, hint="record longer")
    h = usual_step(t, grouped=found.policy.gaps is None)
    if declared is not None and abs(h - declared) > 0.01 * declared:
        what = f"samples are {h:.6g} s apart, sampling_time says {declared:.6g} s"
        raise InputError(what, where=found.table.path, hint="give the time column's unit, or correct sampling_time")
    return declared or h


def _bridge(found: Findings, counts: NDArray[np.intp], missing: int) -> None:
    """Say that gaps are filled, or refuse."""
    longest = int(counts.max()) - 1
    everything = int(counts.sum()) + 1
    if missing > MAX_MISSING * everything:
        what = f"{missing} of {everything} samples are missing between the others"
        raise InputError(what, where=found.table.path, hint="record again at a rate that the logger keeps up with")
    repaired = found.policy.gaps is None and few(missing, longest, everything)
    refused = found.policy.gaps != "interpolate" and not repaired
    k = int(np.argmax(counts) if refused else np.argmax(counts > 1)) + 1
    where = found.where(k)
    plural = f"{missing} samples are missing" if missing > 1 else "1 sample is missing"
    if refused:
        hint = "cut the record there by start or stop, or set repair: {gaps: interpolate}"
        which = " before this one" if longest == missing else f", {longest} of them before this one"
        raise InputError(plural + which, where=where, hint=hint)
    found.remarks.append(f"{plural} and interpolated, the first before {where}")
