"""What an encoder's rounding adds to an output: a noise whose spectrum follows from the motion and the quantum.

Where a motor passes many quanta a sample, rounding errors are white (Widrow and Kollár 2008). Where it takes several
samples from one count to the next they are a sawtooth, whose spectrum moves with the speed. The motion is known well
enough to tell it: at the instants at which the count changes, the angle is known. An encoder that is turned by a
fraction of a quantum makes other errors of the same motion; their spectrum is the mean over all such fractions.
"""

from __future__ import annotations

import numpy as np
from scipy.signal.windows import hann

from robotid.diagnosis.noise.settings import NOISE
from robotid.model.array import Array
from robotid.signals.derivation import Derivation
from robotid.signals.quality import quantum
from robotid.signals.record import Quantity, Record

SEED = 0  # of the instants that nobody knows


def quantisation_spectrum(record: Record, output: Quantity) -> Array | None:
    """Spectrum (n // 2 + 1,) of an encoder's errors under a Hann taper, where these leave a variance of one in an
    output of the record as a whole, and white ones would have the same at every frequency. None where the output does
    not come from the angle, or no quantum shows in it.

    For a derived speed, too, it is that of the angle, and one for white errors. It is larger where the errors gather in
    the middle of the record, and the taper shows more of them than there are on average.
    """
    derivation = Derivation.of(record, output)
    step = quantum(record.phi_m) if derivation is not None or output == "position" else 0.0
    if step == 0.0:
        return None
    taper, rng = hann(len(record.phi_m) + 2)[1:-1], np.random.default_rng(SEED)
    power, energy = np.zeros(len(record.phi_m) // 2 + 1), 0.0
    for fraction in (np.arange(NOISE.encoder_turns) + 0.5) / NOISE.encoder_turns:
        error = rounding_error(between_counts(record.phi_m, step, rng), step, fraction)
        power += np.abs(np.fft.rfft(taper * error)) ** 2
        energy += float(np.sum((error if derivation is None else derivation.speed(error)) ** 2))
    gain = 1.0 if derivation is None else derivation.gain
    return _smooth(power) * gain * len(taper) / (energy * float(np.sum(taper**2)))


def rounding_error(angle: Array, step: float, fraction: float) -> Array:
    """The error (n,) of an encoder that is turned by a fraction of its step. angle : (n,)."""
    counts = angle / step + fraction
    return np.asarray(step * (np.rint(counts) - counts))


def between_counts(angle: Array, step: float, rng: np.random.Generator) -> Array:
    """An angle (n,) as it may have been: it passes in straight lines from count to count, where a rounded one (n,)
    jumps. The middle of a jump is passed at some moment within its sampling interval, in the middle of that to within
    half a quantum."""
    jumps = np.diff(angle) / step
    at = np.flatnonzero(np.abs(jumps) > 0.5)
    if not len(at):
        return angle
    instants = at + 0.5 + rng.uniform(-0.5, 0.5, len(at)) / np.maximum(1.0, np.abs(jumps[at]))
    return np.asarray(np.interp(np.arange(len(angle)), instants, (angle[at] + angle[at + 1]) / 2))


def _smooth(power: Array) -> Array:
    """A spectrum as it is on average over neighbouring lines, in bands of a constant relative width: which line of a
    band a sawtooth meets is chance."""
    m = len(power)
    lines = np.arange(m)
    half = np.maximum(1, np.round(NOISE.encoder_band / 2 * lines)).astype(np.intp)
    total = np.concatenate([[0.0], np.cumsum(power)])
    first, beyond = np.maximum(0, lines - half), np.minimum(m, lines + half + 1)
    return np.asarray((total[beyond] - total[first]) / (beyond - first))
