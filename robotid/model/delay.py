"""A delay by any time, as a mix of two neighbouring samples."""

from __future__ import annotations

from math import floor

import numpy as np

from robotid.model.array import Array


def delayed(signal: Array, delay: float) -> tuple[Array, Array]:
    """A signal late by `delay` samples, and its derivative to the delay. signal (..., n) -> the same shape, twice.

    Between samples n - k - 1 and n - k for a delay of k + f; the first value stands for all before the record. At whole
    samples the derivative is the one to the right.
    """
    whole = floor(delay)
    at = np.arange(signal.shape[-1]) - whole
    later, earlier = signal[..., np.maximum(at, 0)], signal[..., np.maximum(at - 1, 0)]
    slope = earlier - later
    return np.asarray(later + (delay - whole) * slope), np.asarray(slope)
