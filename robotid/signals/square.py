"""The square wave: constant speed away from zero, which keeps static friction out of a superposed multisine."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array
from robotid.signals.triangle import triangle


def square(amplitude: float, period: int, samples: int, rise: float = 0.0) -> Array:
    """Square wave, high in the first half period, (samples,). period in samples.

    rise : samples that a reversal takes, at most half a period, at which a triangle is left. Reversals are then ramps
    that pass zero where the wave without rise switches.
    """
    if rise > 0:
        return np.clip(triangle(amplitude * period / (2 * rise), period, samples), -amplitude, amplitude)
    return np.where(2 * (np.arange(samples) % period) < period, amplitude, -amplitude)
