"""What a person reads off a frequency response: notch, resonance and high-frequency gain (section 6.2 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy

from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.signals.frf import Frf
from robotid.signals.frf_matrix import FrfMatrix

MIN_PROMINENCE = 3.0  # [dB] of a notch or a resonance over its surroundings
# Standard deviations of the response that a prominence must exceed, too: hundreds of lines scatter so far.
MIN_SIGNIFICANCE = 7.0
FLAT_FROM = 3.0  # times the resonance: from here on the response is flat


@dataclass(frozen=True, slots=True)
class Reading:
    """notch, resonance : the most prominent ones [rad/s], None where there is none.
    gain : magnitude at high frequency, 1/Jm."""

    notch: float | None = field(metadata={"unit": "rad/s"})
    resonance: float | None = field(metadata={"unit": "rad/s"})
    gain: float = field(metadata={"unit": "rad/s2/Nm"})


def read_off(frf: Frf) -> Reading:
    """Notch, resonance and gain of a response from torque to acceleration."""
    if not np.all(np.abs(frf.response) > 0.0):
        what = "the speed does not respond to the torque at some frequencies"
        raise NumericsError(what, where=frf.record, hint="check the column of the speed, or write dphi_m: null")
    level = 20 * np.log10(np.abs(frf.response))
    doubt = MIN_SIGNIFICANCE * 20 * np.log10(1 + frf.std / np.abs(frf.response))
    notches, peaks = (_extremes(sign * level, doubt, frf.omega) for sign in (-1, 1))
    notch = notches[0] if notches else None
    above = [peak for peak in peaks if notch is None or peak > notch]
    resonance = above[0] if above else None
    far = frf.omega > FLAT_FROM * (resonance or 0.0)
    high = far if resonance and far.sum() >= 3 else frf.omega >= np.quantile(frf.omega, 0.8)
    return Reading(notch, resonance, float(np.median(np.abs(frf.response[high]))))


def read_off_axes(matrix: FrfMatrix) -> dict[str, Reading]:
    """What every axis shows while the motors of all others stand, by its name: its notch is then that of its own gear
    and arm, whatever the others do."""
    return {axis: read_off(matrix.alone(axis)) for axis in matrix.axes}


def _extremes(level: Array, doubt: Array, omega: Array) -> list[float]:
    """Frequencies of the maxima of a level [dB], between the lines by a parabola, the most prominent first.

    doubt (n,) [dB] : what noise alone may raise.
    """
    where, about = scipy.signal.find_peaks(level, prominence=np.maximum(MIN_PROMINENCE, doubt))
    order = np.argsort(-about["prominences"])
    return [_vertex(level[k - 1 : k + 2], omega[k - 1 : k + 2]) for k in where[order]]


def _vertex(level: Array, omega: Array) -> float:
    a, b, _ = np.polyfit(omega - omega[1], level, 2)
    return float(omega[1] - b / (2 * a)) if a < 0 else float(omega[1])
