"""Signals as figures need them: a long one by the extremes of its stretches, so that no peak is lost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from robotid.model.array import Array, Index

MAX_SAMPLES = 16_000  # samples kept
KEPT_PER_STRETCH = 4  # of a stretch: least and largest of the measured signal and of the difference


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A measured and a simulated signal for figures, (n,), of a long record the extremes of every stretch."""

    t: Array = field(metadata={"unit": "s", "shape": ("n",), "finite": True})
    measured: Array = field(metadata={"unit_in": "unit", "shape": ("n",), "finite": True})
    simulated: Array = field(metadata={"unit_in": "unit", "shape": ("n",), "finite": True})
    unit: str

    def contradictions(self) -> Iterator[str]:
        """What cannot be, as sentences: for a trace that was read from a file."""
        if len(self.t) > 1 and not np.diff(self.t).min() > 0.0:
            yield "the samples of a trace are not one after the other"

    @property
    def sampling_time(self) -> float:
        """Of the signal that it was made of [s], as far as two neighbouring samples are left."""
        return float(np.diff(self.t).min()) if len(self.t) > 1 else 1.0


def downsampled(t: Array, measured: Array, simulated: Array, unit: str) -> Trace:
    """A measured and a simulated signal (n,), whole, or of n > MAX_SAMPLES samples the extremes of every stretch."""
    if len(t) <= MAX_SAMPLES:
        return Trace(t, measured, simulated, unit)
    stretches = MAX_SAMPLES // KEPT_PER_STRETCH
    at = np.unique(np.concatenate([_extremes(signal, stretches) for signal in (measured, measured - simulated)]))
    return Trace(t[at], measured[at], simulated[at], unit)


def _extremes(signal: Array, stretches: int) -> Index:
    """Where the least and the largest sample of each stretch are, (2 stretches,) or fewer."""
    size = -(-len(signal) // stretches)
    padded = np.concatenate([signal, np.full(-len(signal) % size, signal[-1])]).reshape(-1, size)
    first = size * np.arange(len(padded))
    at = np.concatenate([first + padded.argmin(axis=1), first + padded.argmax(axis=1)])
    return np.asarray(np.minimum(at, len(signal) - 1))
