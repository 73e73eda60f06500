"""Signals without the white noise of a sensor: every frequency weighed by how far it stands out of the floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array

BAND = 201  # lines of the spectrum over which it is averaged, at most
OWN = 2.0  # times the noise that is known: a floor above that is no noise
SHORTEST = 64  # samples in which a floor can be seen


@dataclass(frozen=True, slots=True, eq=False)
class WithoutFloor:
    """The Wiener filter for white noise, which shifts nothing in time. passed : of every line of the spectrum, (n,), of
    a signal and its mirror image, which has no step at its ends; None where all of it passes."""

    passed: Array | None

    @classmethod
    def of(cls, noisy: Array, variance: float) -> WithoutFloor:
        """The filter for a signal (n,), and for whatever it drives, which has as much of the noise at each frequency.

        variance : of white noise that is known to be there, about. The floor is the typical level of the upper half of
        all frequencies; one that is far above the known noise is the signal's own, and all of it passes, as where the
        signal is too short to tell.
        """
        n = len(noisy)
        if n < SHORTEST or variance <= 0.0:
            return cls(None)
        from scipy.fft import dct  # late: a configuration is read without it
        from scipy.ndimage import uniform_filter1d

        power = uniform_filter1d(dct(noisy, norm="ortho") ** 2, min(BAND, n // 8), mode="nearest")
        floor = float(np.median(power[n // 2 :]))
        if floor > OWN * variance:
            return cls(None)
        return cls(np.clip(1.0 - floor / np.maximum(power, 1e-300), 0.0, 1.0))

    def __call__(self, signals: Array) -> Array:
        """Signals (..., n) through the filter."""
        if self.passed is None:
            return signals
        from scipy.fft import dct, idct

        return np.asarray(idct(self.passed * dct(signals, norm="ortho"), norm="ortho"))
