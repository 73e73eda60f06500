"""Stretches of a long record: as much of it as a search can hold in memory, from all over it."""

from __future__ import annotations

import numpy as np

from robotid.signals.record import Record

MAX_STRETCHES = 5  # stretches of a record


def stretches(record: Record, samples: int) -> tuple[Record, ...]:
    """A record whole, or of a longer one up to MAX_STRETCHES stretches of about `samples` in all, evenly from its
    beginning to its end. Each holds a whole period where that is known, and the samples allow it."""
    if len(record) <= samples:
        return (record,)
    return tuple(record.piece(at.start, at.stop) for at in stretches_at(record, samples))


def stretches_at(record: Record, samples: int) -> tuple[slice, ...]:
    """Where the stretches of a record are."""
    if len(record) <= samples:
        return (slice(0, len(record)),)
    period = 0 if record.period is None else round(record.period / record.sampling_time)
    count = min(MAX_STRETCHES, samples // period) if 0 < period <= samples else MAX_STRETCHES
    length = max(1, samples // count)
    first = np.linspace(0, len(record) - length, count).round().astype(int) if count > 1 else np.zeros(1, dtype=int)
    return tuple(slice(k, k + length) for k in first.tolist())
