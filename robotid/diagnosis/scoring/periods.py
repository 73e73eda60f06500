"""Periods in the misfit: how often a turn an effect that goes round with an angle would have to repeat itself.

A grid cannot hold them: a record of many turns tells numbers of periods apart that lie closer than any grid. What the
residual gains from a torque at each sample, found by one adjoint solve, is summed over the angle to a spectrum, and the
spectrum's peaks are scored beside the grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from scipy.ndimage import median_filter

from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Wave:
    """angle [rad] (n,) that an effect goes round with, and weight (n,) : what the residual gains from it there."""

    angle: Array
    weight: Array


def period_peaks(waves: Sequence[Wave], grid: Sequence[float], *, linear: bool = False) -> Iterator[float]:
    """Numbers of periods a turn, within the grid's range, at which the sum of weight exp(i n angle) over all waves
    peaks; none where the motion has too many turns for one spectrum.

    linear : the axis slides, and "angle" is its position [m]. It has no turns, and its pitch may be of any length: up
    to as many periods of the whole motion are sought as elsewhere of a turn.
    """
    angle = np.concatenate([wave.angle for wave in waves])
    weight = np.concatenate([wave.weight for wave in waves])
    span = float(np.ptp(angle))
    if span <= 0.0:
        return
    most = max(grid) * max(1.0, 2 * np.pi / span) if linear else max(grid)
    bins = 2 ** int(np.ceil(np.log2(max(2.0, SCORING.bins_a_period * most * span / (2 * np.pi)))))
    if bins * SCORING.zero_padding > SCORING.max_spectrum_points:
        return
    n, power = spectrum_along(angle, weight, bins)
    inside = (n >= max(min(grid), np.pi / span)) & (n <= most)
    standing = power / np.maximum(median_filter(power, SCORING.peak_surroundings), 1e-300)
    found, _ = scipy.signal.find_peaks(np.where(inside, power, 0.0))
    best = (sorted(found, key=lambda i: -height[i])[: SCORING.period_peaks] for height in (power, standing))
    highest, prominent = best
    shifts = range(-SCORING.peak_shift, SCORING.peak_shift + 1)
    chosen = {int(i) + shift for i in highest for shift in shifts} | {int(i) for i in prominent}
    yield from (float(n[i]) for i in sorted(chosen) if 0 < i < len(n))


def spectrum_along(angle: Array, weight: Array, bins: int) -> tuple[Array, Array]:
    """Numbers of periods a turn (f,), and the squared sum of weight exp(i n angle) at each, (f,), by so many bins of an
    angle that moves (n,)."""
    low, span = float(angle.min()), float(np.ptp(angle))
    at = np.minimum(((angle - low) * (bins / span)).astype(int), bins - 1)
    power = np.abs(np.fft.rfft(np.bincount(at, weight, bins), SCORING.zero_padding * bins)) ** 2
    return np.asarray(2 * np.pi * np.arange(len(power)) / (SCORING.zero_padding * span)), np.asarray(power)
