"""Resonances in the misfit: the frequency at which an effect with a resonance of its own would have to ring.

A grid cannot hold it where there is so little damping that the resonance is narrower than any grid. What the residual
gains from a force at each sample is compared, frequency by frequency, with what the effect makes of the motion; where
it peaks, the effect is scored beside the grid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """speed (n,) of an effect's port, and gain (n,) : what the residual gains from a torque there."""

    speed: Array
    gain: Array
    sampling_time: float


def resonance_peaks(
    drives: Sequence[Drive],
    response: Callable[[float], Callable[[Array], Array]],
    grid: Sequence[float],
    one_sided: bool,
) -> list[float]:
    """Frequencies [rad/s], within the grid's range, at which what an effect gains peaks, the highest first.

    response : of a resonance at a frequency, torque per speed over frequencies (n,). one_sided : the effect cannot be
    negative.
    """
    omega, cross = _cross_spectrum(drives, SCORING.resonance_range * max(grid))
    points = np.geomspace(min(grid), max(grid), SCORING.resonance_points)
    gain = np.array([np.real(response(float(w))(omega) @ cross) for w in points])
    height = gain if one_sided else np.abs(gain)
    found, _ = scipy.signal.find_peaks(np.maximum(height, 0.0))
    return [float(points[i]) for i in sorted(found, key=lambda i: -height[i])[: SCORING.resonance_peaks]]


def _cross_spectrum(drives: Sequence[Drive], most: float) -> tuple[Array, Array]:
    """Frequencies up to `most` [rad/s], and the cross-spectrum of gain and speed there, of all drives together."""
    span = 2 * max(len(one.speed) * one.sampling_time for one in drives)  # padded: a record is no period
    omega = np.arange(1.0, most * span / (2 * np.pi)) * (2 * np.pi / span)
    total = np.zeros(len(omega), dtype=complex)
    for one in drives:
        n = round(span / one.sampling_time)
        cross = (np.conj(np.fft.rfft(one.gain, n)) * np.fft.rfft(one.speed, n))[1 : len(omega) + 1]
        total[: len(cross)] += cross * one.sampling_time
    return omega, total
