"""The samples behind a curve of the missing torque: asked for by the residual, added, left."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.misfit.curve import BY_DIRECTION, IN_PROPORTION, Curve
from robotid.diagnosis.misfit.location import since_reversal
from robotid.model.array import Array, Mask
from robotid.model.physical import TURN
from robotid.report.findings import Findings
from robotid.signals.record import Record

SLOW = 0.3  # of the motion that a curve is for: slower samples show nothing of a torque that is in proportion to it
MAX_STRETCHES = 24  # of a bin in a record, the longest ones
MIN_GAP = 3  # samples between two stretches, less joins them


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Of one record, (n,) each: time [s], the curve's variable, and torques [Nm] counted as the curve counts them. left
    : what the residual asks for once the causes are there, law : of the extension, None where unknown."""

    record: str
    t: Array
    x: Array
    asked: Array
    left: Array | None
    law: Array | None


@dataclass(frozen=True, slots=True, eq=False)
class Bins:
    """Mean and spread of a torque in the bins of a curve, (bins,) each, nan in an empty one."""

    mean: Array
    spread: Array


def samples(f: Findings, curve: Curve) -> tuple[Samples, ...]:
    """Of all records on which the variable of the curve is known."""
    return tuple(_samples(f, curve))


def in_bins(curve: Curve, found: tuple[Samples, ...], torque: str) -> Bins | None:
    """One torque of the samples, asked, left or law, in the bins of the curve; None where a record lacks it."""
    if not found or any(getattr(one, torque) is None for one in found):
        return None
    x, values = (np.concatenate([getattr(one, name) for one in found]) for name in ("x", torque))
    known = np.isfinite(values) & np.isfinite(x)
    bins = bin_of(curve, x[known])
    size = len(curve.x)
    count = np.bincount(bins, minlength=size).astype(np.float64)
    count[count == 0] = np.nan
    mean = np.bincount(bins, values[known], size) / count
    spread = np.sqrt(np.bincount(bins, (values[known] - mean[bins]) ** 2, size) / count)
    return Bins(mean, spread)


def bin_of(curve: Curve, x: Array) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """The bin whose centre is nearest, (n,)."""
    return np.searchsorted((curve.x[1:] + curve.x[:-1]) / 2, x)


def stretches(curve: Curve, found: tuple[Samples, ...]) -> list[dict[str, list[tuple[float, float]]]]:
    """By bin and record, when the record is in the bin [s], in the order of time."""
    return [{one.record: times for one in found if (times := _times(curve, one, k))} for k in range(len(curve.x))]


def _times(curve: Curve, one: Samples, k: int) -> list[tuple[float, float]]:
    inside = np.flatnonzero((bin_of(curve, one.x) == k) & np.isfinite(one.x))
    if not len(inside):
        return []
    breaks = np.flatnonzero(np.diff(inside) > MIN_GAP)
    first, last = inside[np.r_[0, breaks + 1]], inside[np.r_[breaks, -1]]
    longest = np.sort(np.argsort(last - first, kind="stable")[::-1][:MAX_STRETCHES])
    return [(float(one.t[a]), float(one.t[b])) for a, b in zip(first[longest], last[longest], strict=True)]


def _samples(f: Findings, curve: Curve) -> Iterator[Samples]:
    name, _, counted = curve.along.partition(",")
    if f.diagnosis is None or f.recordings is None:
        return
    for record in f.recordings.records:
        missing, law = f.diagnosis.missing.get(record.name), f.evidence.laws.get(record.name)
        if missing is None:
            continue
        t, known = missing.t, variables_at(f, record)
        if not all(needed in known for needed in curve.needs):
            continue
        weight, kept = _weight(known, counted, curve.at)
        causes = bool(f.diagnosis.causes) and bool(np.any(missing.simulated))
        yield Samples(
            record.name,
            t[kept],
            known[name][kept],
            (missing.measured / weight)[kept],
            ((missing.measured - missing.simulated) / weight)[kept] if causes else None,
            None if law is None else (_at(t, law.t, law.torque) / weight)[kept],
        )


def along_companion(name: str) -> str:
    """What a curve along a companion runs along."""
    return f"companion[{name}]"


def variables_at(f: Findings, record: Record) -> dict[str, Array]:
    """What a curve may run along, at the times of a record's missing torque, (n,) each: as the extended model moves, or
    as recorded; the twist as the diagnosis has it."""
    assert f.diagnosis is not None
    t, law = f.diagnosis.missing[record.name].t, f.evidence.laws.get(record.name)
    found = {name: _at(t, record.t, values) for name, values in _variables(record).items()}
    if law is not None:
        found |= {name: _at(t, law.t, values) for name, values in law.variables.items()}
    return found | ({"twist": f.diagnosis.twist[record.name]} if record.name in f.diagnosis.twist else {})


def _at(t: Array, times: Array, values: Array) -> Array:
    return np.asarray(values[np.clip(np.searchsorted(times, t - 1e-9), 0, len(times) - 1)])


def _weight(known: Mapping[str, Array], counted: str, scale: float) -> tuple[Array, Mask]:
    """What a torque is divided by to be counted, and the samples that can be. known : variables, (n,) each."""
    speed = known["dphi_m"]
    if counted in IN_PROPORTION:
        moved = known[IN_PROPORTION[counted]]
        kept = np.abs(moved) > SLOW * scale
        return np.where(kept, moved / scale, 1.0), kept
    if counted == BY_DIRECTION:
        return np.where(speed < 0, -1.0, 1.0), speed != 0
    return np.ones(len(speed)), np.ones(len(speed), dtype=bool)


def _variables(record: Record) -> dict[str, Array]:
    """What is known of a record without a model, (n,) each."""
    speed, h = record.dphi_m, record.sampling_time
    return {along_companion(name): one.values for name, one in record.companions.items()} | {
        "dphi_m": speed,
        "phi_m": record.phi_m,
        "phi_m mod 2 pi": record.phi_m % TURN,
        "ddphi_m": np.gradient(speed, h),
        "tau_m": record.tau_m,
        "t": record.t,
        "reversal": since_reversal(speed, h),
    }
