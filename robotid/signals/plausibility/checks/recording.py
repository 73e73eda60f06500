"""The recording itself: clock, resolution, saturation, and what of the joint the motion shows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from robotid.model.array import Array
from robotid.numerals import plain
from robotid.signals.plausibility.check import Remark, check
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.settings import CHECK
from robotid.signals.record import Record

COMPARED = 4000  # samples of a record, to which it is thinned before motions are compared


@check(unless=("speed_scale",))
def sampling_size(evidence: Evidence) -> Iterator[Remark]:
    """The sampling time is one that no drive has, as where the time is in another unit."""
    h = evidence.record.sampling_time
    if CHECK.fast_sampling <= h <= CHECK.slow_sampling:
        return
    surely = h > CHECK.impossible * CHECK.slow_sampling or h < CHECK.fast_sampling / CHECK.impossible
    guess = "ms" if h > CHECK.slow_sampling and h < 1e3 * CHECK.slow_sampling else "us" if h > 1.0 else "min"
    yield Remark(
        "fatal" if surely else "warning",
        f"the sampling time is {plain(h)} s",
        "inertia is wrong by the square of the factor of time, friction and every speed by the factor",
        f"give the unit of the time column, t: {{name: ..., unit: {guess}}}, or correct sampling_time",
    )


@check(unless=("sampling_size",))
def clock(evidence: Evidence) -> Iterator[Remark]:
    """The sampling intervals vary, or samples are missing."""
    report, record = evidence.report, evidence.record
    unit = evidence.units["speed"]
    if report.jitter_rms > CHECK.jitter:
        acceleration = float(np.std(np.diff(evidence.derived_speed))) / record.sampling_time
        cost = report.jitter_rms * record.sampling_time * acceleration
        yield Remark(
            "warning" if report.jitter_rms > CHECK.much_jitter else "note",
            f"the sampling intervals vary by {plain(100 * report.jitter_rms, 2)} % RMS and"
            f" {plain(100 * report.jitter, 2)} % at most",
            f"stamps that are wrong by as much add about {plain(cost, 2)} {unit} of noise to the speed",
            "use the time stamps of the drive rather than those of the receiver, or record with a real-time clock",
        )
    if report.missing > CHECK.missing * report.samples:
        yield Remark(
            "warning",
            f"{report.missing} of {report.samples} samples were missing and are filled in",
            "motion and torque are guesses there",
            "cut the record by start and stop, or record again",
        )


@check(unless=("angle_unit",))
def quantisation(evidence: Evidence) -> Iterator[Remark]:
    """The encoder is coarse for the motion."""
    report, record = evidence.report, evidence.record
    if not report.quantum:
        return
    # white noise of q / sqrt(12) in the angle, through a central difference
    noise = report.quantum / (record.sampling_time * np.sqrt(24.0))
    speed = float(np.sqrt(np.mean(record.dphi_m**2)))
    if evidence.speed_is_derived and noise > CHECK.coarse * speed:
        unit = evidence.units
        yield Remark(
            "warning",
            f"a step of the encoder is {plain(report.quantum)} {unit['angle']}: {plain(noise, 2)} {unit['speed']} of"
            f" noise in the derived speed, {plain(100 * noise / speed, 2)} % of it",
            "small effects disappear in the noise of the derived speed",
            "set fit: {output: position}, or record a finer angle or the drive's own speed",
        )


@check(unless=("torque_levels",))
def saturation(evidence: Evidence) -> Iterator[Remark]:
    """The torque sits at its limits."""
    share = evidence.report.saturation
    if share > CHECK.saturated:
        yield Remark(
            "warning",
            f"the torque is at its largest or smallest value in {plain(100 * share, 2)} % of the samples",
            "a command that the drive cut off is not the torque that acted",
            "add the effect saturation to torque, or record a smaller motion",
        )


@check(unless=("speed_empty",))
def standstill(evidence: Evidence) -> Iterator[Remark]:
    """The motor rests for most of the record."""
    if evidence.report.still > CHECK.still:
        yield Remark(
            "warning",
            f"the motor rests in {plain(100 * evidence.report.still, 2)} % of the samples",
            "at rest, dry friction takes any torque, and nothing is learnt",
            "cut the record by start and stop",
        )


@check(unless=("speed_empty", "speed_unrelated"))
def reversals(evidence: Evidence) -> Iterator[Remark]:
    """The motor never reverses."""
    if evidence.report.reversals == 0:
        yield Remark(
            "note",
            "the motor never reverses",
            "dry friction cannot be distinguished from a constant torque",
            "use it beside a record that reverses, or fix one of the two",
        )


@check()
def repetition(evidence: Evidence) -> Iterator[Remark]:
    """A validation record repeats the motion of a record of the fit."""
    for other in evidence.others:
        if repeats(evidence.record, other):
            yield Remark(
                "note",
                f"it repeats the motion of {other.name}, which is fitted",
                "it shows that the joint repeats itself, and not that the model predicts other motions",
                "validate with another motion",
            )
            return


def repeats(one: Record, other: Record) -> bool:
    """Whether two records of one sampling time hold the same motion."""
    return abs(other.sampling_time / one.sampling_time - 1) < 1e-6 and _same_motion(one, other)


def _same_motion(one: Record, other: Record) -> bool:
    """Whether two records hold the same motion, one perhaps later: peak of the correlation of their angles where they
    overlap by half of the shorter one at least."""
    step = -(-max(len(one), len(other)) // COMPARED)
    a, b = (np.diff(r.phi_m[::step]) for r in (one, other))
    cross = scipy.signal.correlate(a, b, mode="full")
    size = np.sqrt(_overlapping(a**2, len(b)) * _overlapping(b**2, len(a))[::-1])
    at_least = min(len(a), len(b)) // 2
    enough = _overlapping(np.ones_like(a), len(b)) >= at_least
    kept = enough & (size > 1e-12 * float(size.max(initial=0.0)))
    return bool(kept.any()) and float(np.max(cross[kept] / size[kept])) > CHECK.repeat


def _overlapping(square: Array, other: int) -> Array:
    """Sum of a signal (n,) over its overlap with one of `other` samples, at every shift, (n + other - 1,)."""
    sums = np.concatenate([[0.0], np.cumsum(square)])
    last = np.arange(1, len(square) + other)
    return np.asarray(sums[np.minimum(last, len(square))] - sums[np.maximum(last - other, 0)])
