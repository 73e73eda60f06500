"""A tone in the recorded torque that the motion does not show, and records from which it is taken.

The log of a drive may hold the hum of its supply, of a fan or of a pump, and where something from outside shakes a
machine at one frequency, its controller's torque holds against it. The simulation is driven with such a tone and swings
where the machine did not. It is no effect of the joint, and no noise that a smooth spectrum describes.

An effect that is periodic in an angle makes a tone too while the speed is constant, and the controller holds against
that as well. It keeps in step with the angle, where a tone keeps in step with time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter
from scipy.optimize import minimize_scalar
from scipy.signal.windows import hann

from robotid.diagnosis.results import Tone
from robotid.diagnosis.scoring.periods import spectrum_along
from robotid.estimate.fitted_model import Simulated
from robotid.estimate.noise.lines import periodogram
from robotid.model.array import Array
from robotid.numerals import listed, plain
from robotid.signals.record import Quantity, Record

LEVEL = 1e-3  # of significance of a tone, among all lines of a record
AROUND = 24  # lines to either side whose median is the noise at a line; a tone has as many periods at least
MOST = 5  # tones of a record
IN_STEP = 0.5  # share of a tone's energy from which what keeps in step with the angle is no tone
UNSEEN = 0.5  # of what the simulation makes of a tone: the motion shows less of it
SPEEDS = 20.0  # between the fastest of a record and the slowest at which an effect periodic in the angle makes a tone
RARE = 0.02  # share of the samples whose speed may be faster still, by noise, and by so much:
FASTER = 1.5
BINS_A_PERIOD = 4  # of the angle, of the shortest period of such an effect
NEAR = 10  # lines to either side of a tone that may be part of it
SAME = 0.01  # relative: frequencies that are closer are one


def without_tones(record: Record, tones: Iterable[Tone]) -> Record:
    """The record without the tones in its torque. record : whole, or a stretch or a piece of one."""
    own = [one for one in tones if one.record == record.name]
    return replace(record, tau_m=record.tau_m - sum(one.at(record.t) for one in own)) if own else record


def tones(run: Simulated, output: Quantity) -> Iterator[Tone]:
    """The tones in the torque of a simulated record, the strongest in its residual first.

    A tone stands out of its neighbours in the torque and in the residual, and not in the motion. Where others of these
    neighbours stand out in both torque and motion, the torque repeats itself with the motion, and moves the joint at
    one of its lines less than at others, as where what hangs on a motor absorbs it.
    """
    record, n = run.record, len(run.record)
    if n < 4 * AROUND:
        return
    torque, left, taper = record.tau_m, run.residual(output), hann(n, sym=False)
    shown = _lines(run.measured(output))
    level, moved = np.log(len(shown) / LEVEL), _standing_out(shown)
    repeated = (moved > level) & (_standing_out(_lines(torque)) > level)
    alone = maximum_filter1d(repeated, 2 * AROUND + 1, mode="constant") == 0
    possible = alone & (moved < -np.log(LEVEL)) & (np.arange(1, len(shown) + 1) >= AROUND)
    for _ in range(MOST):
        simulated = _lines(left)
        standing = _standing_out(simulated)
        heard = possible & (standing > level) & (_standing_out(_lines(torque)) > level)
        heard &= shown < UNSEEN**2 * simulated
        if not heard.any():
            return
        k = int(np.argmax(np.where(heard, standing, 0.0)))
        possible[max(0, k - 2) : k + 3] = False
        in_left = _tone(left, record, taper, _frequency(left, record, taper, k + 1))
        if _follows_the_angle(left, record, taper, in_left):
            continue
        one = _tone(torque, record, taper, in_left.frequency)
        torque, left = torque - one.at(record.t), left - in_left.at(record.t)
        yield one


def as_remarks(found: Sequence[Tone], unit: str) -> Iterator[str]:
    """A sentence for each frequency, of all records in which it is. unit : of the torque."""
    left = sorted(found, key=lambda one: one.frequency)
    while left:
        alike = [one for one in left if one.frequency <= left[0].frequency * (1.0 + SAME)]
        left = left[len(alike) :]
        names, largest = list(dict.fromkeys(one.record for one in alike)), max(one.amplitude for one in alike)
        yield (
            f"the torque of {listed(sorted(names))} holds a tone of {plain(alike[0].frequency)} Hz, up to"
            f" {plain(largest, 2)} {unit}, that the motion does not show, as of a hum in the log or of what shakes it"
            " from outside: taken out before causes were sought"
        )


def _lines(signal: Array) -> Array:
    """Periodogram of a signal (n,) above its mean, from one period in the record on, (n / 2,)."""
    return periodogram(signal - signal.mean())


def _standing_out(lines: Array) -> Array:
    """Each of the lines over the mean of noise around it, whose squared lines have an exponential distribution."""
    noise = median_filter(lines, 2 * AROUND + 1, mode="nearest") / np.log(2.0)
    return np.asarray(lines / np.maximum(noise, 1e-300))


def _along(signal: Array, record: Record, taper: Array, frequency: float) -> complex:
    """Complex amplitude of a signal of a record (n,) at a frequency [Hz]."""
    return complex(2.0 * (taper * signal) @ np.exp(-2j * np.pi * frequency * record.t) / taper.sum())


def _frequency(signal: Array, record: Record, taper: Array, periods: int) -> float:
    """The frequency [Hz] at which a signal (n,) is largest, no more than a period from so many in the record."""
    bounds = (periods - 1) / record.duration, (periods + 1) / record.duration
    found = minimize_scalar(lambda f: -abs(_along(signal, record, taper, f)), bounds=bounds, method="bounded")
    return float(found.x)


def _tone(signal: Array, record: Record, taper: Array, frequency: float) -> Tone:
    """The tone of this frequency [Hz] in a signal of a record (n,)."""
    found, t = _along(signal, record, taper, frequency), record.t
    return Tone(record.name, float(t[0]), float(t[-1]), frequency, found.real, -found.imag)


def _follows_the_angle(left: Array, record: Record, taper: Array, tone: Tone) -> bool:
    """Whether what looks like a tone in the residual (n,) keeps in step with the motor's angle nearly as well as with
    time: at one of the speeds of the record an effect that is periodic in the angle makes it."""
    n, span, omega = len(left), float(np.ptp(record.phi_m)), 2 * np.pi * tone.frequency
    fastest = FASTER * float(np.quantile(np.abs(record.dphi_m), 1.0 - RARE))
    if not (fastest > 0.0 and span > 0.0):
        return False
    spectrum, k = np.fft.rfft(left), round(tone.frequency * record.duration)
    spectrum[: max(0, k - NEAR)] = spectrum[k + NEAR + 1 :] = 0.0
    most = omega * SPEEDS / fastest
    bins = int(BINS_A_PERIOD * most * span / (2 * np.pi)) + 1
    periods, power = spectrum_along(record.phi_m, taper * np.fft.irfft(spectrum, n), bins)
    in_step = power[(periods * fastest >= omega) & (periods <= most)] * (2.0 / taper.sum()) ** 2
    return bool(np.any(in_step > IN_STEP * tone.amplitude**2))
