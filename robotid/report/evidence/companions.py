"""The missing torque along what else was recorded: the angle of another axis, a temperature, a voltage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.diagnosis.misfit.bins import bin_edges
from robotid.diagnosis.misfit.curve import BY_ACCELERATION, BY_DIRECTION, BY_SPEED, Curve
from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.report.evidence.samples import along_companion, variables_at
from robotid.report.findings import Findings
from robotid.signals.record import Record

OF_THE_JOINT = (CompanionKind.DISTURBANCE, CompanionKind.DRIVE)  # kinds that are torques of the motor itself
BLOCKS = 20  # of each record: a block is predicted by all others


def companion_curves(f: Findings) -> tuple[Curve, ...]:
    """The missing torque along every companion, counted in the way in which it is ordered best; what orders it best
    first."""
    if f.diagnosis is None or f.recordings is None:
        return ()
    records = [record for record in f.recordings.records if record.name in f.diagnosis.missing]
    found = []
    for name in dict.fromkeys(name for record in records for name in record.companions):
        having = [record for record in records if name in record.companions]
        one = having[0].companions[name]
        if one.kind in OF_THE_JOINT or not max(float(np.ptp(r.companions[name].values)) for r in having):
            continue
        ways = ("", BY_DIRECTION, BY_SPEED, BY_ACCELERATION)
        found.append(max((_curve(f, name, having, how) for how in ways), key=lambda curve: curve.order))
    return tuple(sorted(found, key=lambda curve: -curve.order))


def _curve(f: Findings, name: str, records: Sequence[Record], how: str) -> Curve:
    """Least squares of the missing torque on what it is counted by, bin by bin."""
    assert f.diagnosis is not None
    parts = []
    for k, record in enumerate(records):
        at, torque = variables_at(f, record), f.diagnosis.missing[record.name].measured
        block = BLOCKS * k + np.arange(len(torque)) * BLOCKS // max(1, len(torque))
        parts.append((at[along_companion(name)], at["dphi_m"], at["ddphi_m"], torque, block))
    x, speed, acceleration, torque, block = (np.concatenate(same) for same in zip(*parts, strict=True))
    moved = {BY_SPEED: speed, BY_ACCELERATION: acceleration}.get(how)
    scale = 1.0 if moved is None else float(np.sqrt(np.nanmean(moved**2))) or 1.0
    weight = np.sign(speed) if how == BY_DIRECTION else np.ones(len(x)) if moved is None else moved / scale
    known = np.isfinite(x) & np.isfinite(torque) & np.isfinite(weight)
    x, torque, weight, block = x[known], torque[known], weight[known], block[known]
    edges = bin_edges(x, signed=False)
    bins, size = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2), len(edges) - 1
    where, shape = block * size + bins, (int(block.max()) + 1, size)
    across = np.bincount(where, weight * torque, shape[0] * size).reshape(shape)
    own = np.bincount(where, weight**2, shape[0] * size).reshape(shape)
    mean = _ratio(across.sum(axis=0), own.sum(axis=0))
    count = np.bincount(bins, minlength=size)
    others = _ratio(across.sum(axis=0) - across, own.sum(axis=0) - own)
    alike = _ratio(across.sum() - across.sum(axis=1), own.sum() - own.sum(axis=1))  # the same in all bins
    left = torque - mean[bins] * weight
    return Curve(
        along=f"{along_companion(name)},{how}" if how else along_companion(name),
        unit=records[0].companions[name].unit,
        x=np.bincount(bins, x, size) / np.maximum(count, 1),
        missing_torque=mean,
        spread=np.sqrt(np.bincount(bins, left**2, size) / np.maximum(count, 1)),
        count=count.astype(np.float64),
        order=_share(torque, alike[block] * weight, others[block, bins] * weight),
        at=scale,
    )


def _ratio(across: Array, own: Array) -> Array:
    """Zero where nothing is known."""
    return np.asarray(np.divide(across, own, out=np.zeros_like(across), where=own > 0))


def _share(torque: Array, alike: Array, predicted: Array) -> float:
    """Of the variance that the companion predicts beyond what is predicted without it, zero where that is less."""
    total = float(np.sum((torque - torque.mean()) ** 2))
    gained = float(np.sum((torque - alike) ** 2) - np.sum((torque - predicted) ** 2))
    return max(0.0, gained / total) if total > 0 else 0.0
