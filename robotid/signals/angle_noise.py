"""The noise of a recorded angle: white, or the rounding of an encoder, and what differentiation makes of it."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array
from robotid.signals.differentiate import transform_length
from robotid.signals.quality import quantum

BANDS = (
    8  # into which the upper half of the spectrum is cut; a motion that reaches there leaves one of them to the noise
)
MEDIAN_OF_EXPONENTIAL = np.log(2.0)  # of a periodogram's ordinates, in means


def angle_noise(angle: Array, sampling_time: float) -> float:
    """Power spectral density of an angle's noise [rad2/Hz], one-sided. angle : (n,).

    What is white is read off the upper half of the spectrum of the second differences, where a motion has died away. An
    encoder's rounding has the variance of a uniform error; it is white where many quanta pass in a sample, and slower
    than that it gathers below the rate at which they pass (Widrow & Kollar 2008).
    """
    return max(_floor(angle, sampling_time), _rounding(angle, sampling_time))


def acceleration_noise(density: float, cutoff: float) -> float:
    """Variance [rad2/s4] that a white noise of an angle leaves in its second derivative below a cut-off [Hz]."""
    return float(density * (2 * np.pi) ** 4 * cutoff**5 / 5)


def _floor(angle: Array, sampling_time: float) -> float:
    second = np.diff(angle, 2)
    n = transform_length(len(second))
    second = second[:n]
    if n < 4 * BANDS:
        return 0.0
    window = np.hanning(n)
    power = np.abs(np.fft.rfft((second - second.mean()) * window)) ** 2 * 2 * sampling_time / float(window @ window)
    gain = (2 * np.sin(np.pi * np.fft.rfftfreq(n))) ** 4
    upper = slice(len(power) // 2, None)
    bands = np.array_split(power[upper] / gain[upper], BANDS)
    return float(min(np.median(band) for band in bands) / MEDIAN_OF_EXPONENTIAL)


def _rounding(angle: Array, sampling_time: float) -> float:
    step = quantum(angle)
    passing = float(np.mean(np.abs(np.diff(angle)))) / (step * sampling_time) if step else 0.0
    return step**2 / 12 / min(0.5 / sampling_time, passing) if passing else 0.0
