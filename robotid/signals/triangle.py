"""The triangle wave: all speeds at constant acceleration, for inertia and friction."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array


def triangle(amplitude: float, period: int, samples: int) -> Array:
    """Triangle wave rising from zero, (samples,). period in samples."""
    quarters = 4 * (np.arange(samples) % period) / period
    return np.asarray(amplitude * np.where(quarters < 2, 1 - np.abs(1 - quarters), np.abs(3 - quarters) - 1))
