"""The most white noise that a recorded torque can hold."""

from __future__ import annotations

import numpy as np
from scipy.signal.windows import hann

from robotid.estimate.noise.settings import SETTINGS, SMALLEST, LevelSettings
from robotid.model.array import Array, Complex

MEDIAN_POWER = 0.693  # of an exponential distribution of mean one


def torque_floor(torque: Array, speed: Array | None = None, settings: LevelSettings = SETTINGS) -> float:
    """Variance of the white noise that a recorded torque (n,) can hold at most: the density of its highest octave.

    speed : (n,) as recorded. A controller makes a torque of the sensor's noise. This torque does act, and is no error
    of the recorded one; so what follows the speed there, by a gain of each band, does not count.
    """
    plain = _highest_octave(torque)
    everything = float(np.median(np.abs(plain) ** 2)) / MEDIAN_POWER
    if speed is None:
        return everything
    seen, bands = _highest_octave(speed), max(1, min(settings.bands, len(plain) // settings.lines))
    left = [
        _unexplained(one, by) for one, by in zip(np.array_split(plain, bands), np.array_split(seen, bands), strict=True)
    ]
    return min(everything, settings.slack * float(np.median(np.concatenate(left))) / MEDIAN_POWER)


def _highest_octave(signal: Array) -> Complex:
    """The spectrum of a signal (n,) under a Hann taper, scaled so that white noise has its variance."""
    taper = hann(len(signal) + 2)[1:-1]
    spectrum = np.fft.rfft(taper * (signal - signal.mean()))[1:] / np.sqrt(np.sum(taper**2))
    return np.asarray(spectrum[len(spectrum) // 2 :])


def _unexplained(lines: Complex, by: Complex) -> Array:
    """Power that one gain of other lines (m,) leaves of lines (m,), without what the gain takes of pure noise."""
    gain = np.vdot(by, lines) / max(float(np.vdot(by, by).real), SMALLEST)
    return np.asarray(np.abs(lines - gain * by) ** 2 * len(lines) / max(1, len(lines) - 1))
