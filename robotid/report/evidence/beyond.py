"""What one variable tells of the missing torque that another does not tell already.

A motor that reverses at two places only has a missing torque near them, whatever friction at small speed is the cause:
the angle orders what the speed orders, and shows nothing more.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.misfit.curve import BY_DIRECTION, IN_PROPORTION, Curve
from robotid.diagnosis.misfit.settings import MISFIT
from robotid.model.array import Array, Index
from robotid.report.evidence.samples import bin_of, variables_at
from robotid.report.findings import Findings

BLOCKS = 20  # of each record: a block is predicted by all others


@dataclass(frozen=True, slots=True, eq=False)
class Binned:
    """Samples as a curve takes them, (n,): bin of each of `size`, and what the torque of a bin is multiplied by."""

    bins: Index
    weight: Array
    size: int


def share_beyond(f: Findings, first: Curve, second: Curve) -> float:
    """Share of the missing torque's variance that the second curve explains of what the first leaves. One where a
    variable or the torque is not known in time."""
    parts = list(_parts(f, first, second))
    if not any(len(torque) for torque, *_ in parts):
        return 1.0
    torque, one, two, block = (np.concatenate(same) for same in zip(*parts, strict=True))
    return beyond(torque, _binned(first, one), _binned(second, two), block)


def beyond(torque: Array, first: Binned, second: Binned, block: Index) -> float:
    """The same on samples (n,). block : of each sample, predicted by all others."""
    left = torque - _predicted(torque, first, block)
    total = float(np.sum((torque - torque.mean()) ** 2))
    gained = float(np.sum(left**2) - np.sum((left - _predicted(left, second, block)) ** 2))
    return max(0.0, gained / total) if total > 0 else 0.0


def _predicted(torque: Array, along: Binned, block: Index) -> Array:
    """Of every sample by its bin in all other blocks, zero where those do not know it, (n,)."""
    shape = (int(block.max()) + 1, along.size)
    where = block * along.size + along.bins
    across, own = (
        np.bincount(where, along.weight * values, shape[0] * shape[1]).reshape(shape)
        for values in (torque, along.weight)
    )
    across, own = across.sum(axis=0) - across, own.sum(axis=0) - own
    mean = np.divide(across, own, out=np.zeros(shape), where=own > 0)
    return np.asarray(mean[block, along.bins] * along.weight)


def _parts(f: Findings, *curves: Curve) -> Iterator[tuple[Array, ...]]:
    """Of each record while it moves: torque (n,), variable and weight of each curve (2, n), block (n,)."""
    assert f.diagnosis is not None
    records = [] if f.recordings is None else f.recordings.records
    for k, record in enumerate(one for one in records if one.name in f.diagnosis.missing):
        known, torque = variables_at(f, record), f.diagnosis.missing[record.name].measured
        if not all(name in known for curve in curves for name in curve.needs):
            return
        along = [np.stack([known[curve.needs[0]], _weight(known, curve)]) for curve in curves]
        block = BLOCKS * k + np.arange(len(torque)) * BLOCKS // max(1, len(torque))
        speed = np.abs(known["dphi_m"])
        kept = speed > MISFIT.standstill * speed.max(initial=0.0)
        kept &= np.isfinite(torque) & np.isfinite(np.concatenate(along)).all(axis=0)
        yield torque[kept], *(one[:, kept].T for one in along), block[kept]


def _weight(known: Mapping[str, Array], curve: Curve) -> Array:
    counted, speed = curve.along.partition(",")[2], known["dphi_m"]
    if counted in IN_PROPORTION:
        return np.asarray(known[IN_PROPORTION[counted]] / curve.at)
    return np.asarray(np.sign(speed)) if counted == BY_DIRECTION else np.ones(len(speed))


def _binned(curve: Curve, along: Array) -> Binned:
    """along : (n, 2) variable and weight."""
    return Binned(bin_of(curve, along[:, 0]), along[:, 1], len(curve.x))
