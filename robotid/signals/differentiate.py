"""Speed and acceleration from a position, without phase error: zero-phase low-pass filter and central differences.

Whatever filter the motion passes, the torque must pass too, or the regression between them is biased (parallel
filtering; Gautier & Poignet 2001; Janot, Gautier & Brunot 2019).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from robotid.model.array import Array, Mask

NYQUIST_SHARE = 0.8  # a cut-off beyond this share of the Nyquist frequency filters nothing worth having
SAMPLES_A_CUTOFF = 4.0  # samples kept a period of the cut-off
FEW_SAMPLES = 20.0  # a period of the cut-off: half a sample is then a phase of nine degrees
LONG = 1_000_000  # samples of a signal whose spectrum may do without the last ones
TRANSFORM_BLOCK = 4_096  # samples: a multiple of it has no large prime factor
POSITION_CUTOFF = 5.0  # of a position's filter, in cut-offs of the parallel filter: it must not shape what that passes


@dataclass(frozen=True, slots=True, eq=False)
class Kinematics:
    """A position [rad], its speed [rad/s] and acceleration [rad/s2], each (n,)."""

    position: Array
    speed: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class ParallelFilter:
    """The zero-phase filter that a motion and its torque both pass.

    cutoff [Hz], None where each record decides; order : of the Butterworth filters; min_speed [rad/s] : slower samples
    are left out.
    """

    cutoff: float | None = None
    order: int = 4
    min_speed: float = 0.0

    def at(self, cutoff: float) -> ParallelFilter:
        """The same filter with its cut-off where it has none yet."""
        return self if self.cutoff else replace(self, cutoff=cutoff)

    def motion(self, position: Array, sampling_time: float) -> Kinematics:
        """Position (n,) and its derivatives, filtered so little that the parallel filter alone shapes them."""
        assert self.cutoff is not None
        motion = differentiate(position, sampling_time, POSITION_CUTOFF * self.cutoff, self.order)
        if not self._is_coarse(sampling_time):
            return motion
        return replace(motion, acceleration=second_difference(motion.position, sampling_time))

    def applied(self, torque: Array, sampling_time: float) -> Array:
        """A torque (n,) that is held from sample to sample, as it is at the samples: the mean of what was before and
        what comes. Where few samples make a period of the cut-off, that lag of half a sample would pass for
        friction."""
        if not self._is_coarse(sampling_time):
            return torque
        return np.asarray((torque + np.concatenate([torque[:1], torque[:-1]])) / 2)

    def _is_coarse(self, sampling_time: float) -> bool:
        """Whether few samples make a period of the cut-off."""
        return self.cutoff is not None and self.cutoff * sampling_time >= 1 / FEW_SAMPLES

    def apply(self, signals: Array, sampling_time: float) -> Array:
        """Signals (..., n) filtered and decimated, (..., n / step)."""
        assert self.cutoff is not None
        return decimate(signals, sampling_time, self.cutoff, self.order)

    def reached_by(self, samples: Mask, sampling_time: float) -> Mask:
        """Where some samples (n,) show most in what the filter leaves of all, (n / step,): within half a period of the
        cut-off of them."""
        from scipy.ndimage import maximum_filter1d  # late: a configuration is read without it

        assert self.cutoff is not None
        around = maximum_filter1d(samples, max(1, round(1 / (self.cutoff * sampling_time))))
        return np.asarray(around[kept(len(samples), sampling_time, self.cutoff)])


AUTOMATIC = ParallelFilter()
"""A filter whose cut-off each record decides."""


def low_pass(signal: Array, sampling_time: float, cutoff: float, order: int = 4) -> Array:
    """Butterworth filter run forwards and backwards, so without phase. signal (..., n) -> (..., n); cutoff [Hz], where
    the gain is 1/2. A cut-off near the Nyquist frequency or beyond returns the signal."""
    nyquist = 0.5 / sampling_time
    if cutoff >= NYQUIST_SHARE * nyquist:
        return signal
    sections = scipy.signal.butter(order, cutoff / nyquist, output="sos")
    pad = min(signal.shape[-1] - 1, int(3 / (cutoff * sampling_time)))
    return np.asarray(scipy.signal.sosfiltfilt(sections, signal, axis=-1, padlen=pad))


def central_difference(signal: Array, sampling_time: float) -> Array:
    """Derivative along the last axis by central differences, one-sided of second order at both ends."""
    return np.asarray(np.gradient(signal, sampling_time, axis=-1, edge_order=2))


def backward_difference(signal: Array, sampling_time: float) -> Array:
    """What has changed since the last sample, over the sampling time, along the last axis; the first as the second."""
    inner = np.diff(signal, axis=-1) / sampling_time
    return np.concatenate([inner[..., :1], inner], axis=-1)


def second_difference(signal: Array, sampling_time: float) -> Array:
    """Second derivative by second differences, at both ends that of the neighbour. signal (n,) -> (n,).

    Under a torque that is held from sample to sample, this is exactly the mean of the accelerations on both sides.
    """
    inner = np.diff(signal, 2) / sampling_time**2
    return np.concatenate([inner[:1], inner, inner[-1:]])


def differentiate(position: Array, sampling_time: float, cutoff: float, order: int = 4) -> Kinematics:
    """Filtered position and its first two derivatives. position (n,); cutoff [Hz]."""
    filtered = low_pass(position, sampling_time, cutoff, order)
    speed = central_difference(filtered, sampling_time)
    return Kinematics(filtered, speed, central_difference(speed, sampling_time))


def decimate(signal: Array, sampling_time: float, cutoff: float, order: int = 4) -> Array:
    """The parallel filter: low-pass, cut the ends that the filter spoils, keep as many samples as the cut-off needs.

    signal (..., n) -> (..., n / step). The ends are one period of the cut-off each, an eighth of the signal at most.
    """
    return low_pass(signal, sampling_time, cutoff, order)[..., kept(signal.shape[-1], sampling_time, cutoff)]


def kept(n: int, sampling_time: float, cutoff: float) -> slice:
    """Which of n filtered samples `decimate` keeps."""
    edge = min(n // 8, round(1 / (cutoff * sampling_time)))
    step = max(1, int(1 / (SAMPLES_A_CUTOFF * cutoff * sampling_time)))
    return slice(edge, n - edge, step)


def bandwidth(signal: Array, sampling_time: float, share: float = 0.99) -> float:
    """Frequency [Hz] below which this share of a signal's energy lies, its mean and noise floor left out. signal (n,).

    The floor is the median of the upper half of the spectrum, where a white noise is all there is.
    """
    n = transform_length(len(signal))
    signal = signal[:n]
    power = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(n))) ** 2
    floor = np.median(power[len(power) // 2 :])
    energy = np.cumsum(np.maximum(power - floor, 0.0))
    if energy[-1] <= 0:
        return 0.0
    return float(np.fft.rfftfreq(n, sampling_time)[np.searchsorted(energy, share * energy[-1])])


def transform_length(n: int) -> int:
    """How many of n samples a spectrum is taken of: all, of a long signal all but some thousands. A Fourier transform
    over a large prime number of samples takes many times the memory and the time."""
    return n if n < LONG else n - n % TRANSFORM_BLOCK
