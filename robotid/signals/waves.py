"""Periodic references: a triangle and a square wave.

A triangle passes all speeds at constant acceleration, for inertia and friction. The constant speed of a square wave
keeps static friction out of a multisine that is added to it.
"""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array


def triangle(amplitude: float, period: int, samples: int) -> Array:
    """Triangle wave rising from zero, (samples,). period in samples."""
    quarters = 4 * (np.arange(samples) % period) / period
    return np.asarray(amplitude * np.where(quarters < 2, 1 - np.abs(1 - quarters), np.abs(3 - quarters) - 1))


def square(amplitude: float, period: int, samples: int, rise: float = 0.0) -> Array:
    """Square wave, high in the first half period, (samples,). period in samples.

    rise : samples that a reversal takes, at most half a period, at which a triangle is left. Reversals are then ramps
    that pass zero where the wave without rise switches.
    """
    if rise > 0:
        return np.clip(triangle(amplitude * period / (2 * rise), period, samples), -amplitude, amplitude)
    return np.where(2 * (np.arange(samples) % period) < period, amplitude, -amplitude)
