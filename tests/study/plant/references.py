"""Reference speeds of the experiments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def triangle(amplitude: float, period: float, duration: float, sampling_time: float) -> Array:
    """Triangle wave that rises from zero [rad/s]; all speeds, at constant acceleration."""
    phase = np.arange(round(duration / sampling_time)) * sampling_time / period
    return np.asarray(4.0 * amplitude * np.abs((phase - 0.25) % 1.0 - 0.5) - amplitude)


def square(amplitude: float, period: float, duration: float, sampling_time: float) -> Array:
    """Square wave, high first [rad/s]."""
    phase = np.arange(round(duration / sampling_time)) * sampling_time / period
    return np.where(phase % 1.0 < 0.5, amplitude, -amplitude)


def multisine(peak: float, period: float, duration: float, sampling_time: float, seed: int) -> Array:
    """Sines of equal size and random phase from 1 to 40 Hz, all multiples of 1 / period [rad/s]."""
    t = np.arange(round(duration / sampling_time)) * sampling_time
    lines = np.arange(round(period), round(40 * period) + 1)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(lines))
    wave = sum(np.cos(2.0 * np.pi * line / period * t + phase) for line, phase in zip(lines, phases, strict=True))
    return np.asarray(peak * wave / np.abs(wave).max())
