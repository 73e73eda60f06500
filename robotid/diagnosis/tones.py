"""A tone in the recorded torque that the motion does not show, and records from which it is taken.

The log of a drive may hold the hum of its supply, of a fan or of a pump, and where something from outside shakes a
machine at one frequency, its controller's torque holds against it. The simulation is driven with such a tone and swings
where the machine did not. It is no effect of the joint, and no noise that a smooth spectrum describes.

An effect that is periodic in an angle makes a tone too while the speed is constant, and the controller holds against
that as well. It keeps in step with the angle, where a tone keeps in step with time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar
from scipy.signal.windows import hann

from robotid.diagnosis.results import Tone
from robotid.estimate.fitted_model import Simulated
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
NEAR = 10  # lines to either side of a tone that may be part of it
SAME = 0.01  # relative: frequencies that are closer are one


def without_tones(record: Record, tones: Iterable[Tone]) -> Record:
    """The record without the tones in its torque. record : whole, or a stretch or a piece of one."""
    own = [one for one in tones if one.record == record.name]
    return replace(record, tau_m=record.tau_m - sum(one.at(record.t) for one in own)) if own else record


def tones(run: Simulated, output: Quantity) -> Iterator[Tone]:
    """The tones in the torque of a simulated record, the strongest in its residual first.

    A tone stands out of its neighbours in the torque and in the residual, and not in the motion.
    """
    record, t, n = run.record, run.record.t, len(run.record)
    if n < 4 * AROUND:
        return
    torque, left, measured = record.tau_m, run.residual(output), run.measured(output)
    apart, taper = np.arange(n // 2 + 1) < AROUND, hann(n, sym=False)
    for _ in range(MOST):
        lines = [_lines(signal, taper) for signal in (torque, left, measured)]
        in_torque, in_left, in_motion = map(_standing_out, lines)
        level = np.log(len(apart) / LEVEL)
        heard = (in_torque > level) & (in_left > level) & (in_motion < -np.log(LEVEL))
        heard &= (lines[2] < UNSEEN**2 * lines[1]) & ~apart
        if not heard.any():
            return
        k = int(np.argmax(np.where(heard, in_left, 0.0)))
        apart[max(0, k - 2) : k + 3] = True
        frequency = _frequency(left, t, taper, k / (n * record.sampling_time))
        if _follows_the_angle(left, record, taper, frequency):
            continue
        one = _fitted(torque, record, taper, frequency)
        torque, left = torque - one.at(t), left - _fitted(left, record, taper, frequency).at(t)
        yield one


def told(found: Sequence[Tone], unit: str, log: Callable[[str], None]) -> Iterator[str]:
    """A sentence for each frequency, of all records in which it is. unit : of the torque; log : is called with it."""
    for sentence in _sentences(found, unit):
        log(sentence)
        yield sentence


def _sentences(found: Sequence[Tone], unit: str) -> Iterator[str]:
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


def _lines(signal: Array, taper: Array) -> Array:
    """Squared lines of a tapered signal (n,) above its mean, (n / 2 + 1,)."""
    return np.asarray(np.abs(np.fft.rfft(taper * (signal - signal.mean()))) ** 2)


def _standing_out(lines: Array) -> Array:
    """Each of the lines over the mean of noise around it, whose squared lines have an exponential distribution."""
    noise = median_filter(lines, 2 * AROUND + 1, mode="nearest") / np.log(2.0)
    return np.asarray(lines / np.maximum(noise, 1e-300))


def _along(signal: Array, taper: Array, phase: Array) -> complex:
    """Complex amplitude of a signal (n,) in step with a phase (n,) [rad]."""
    return complex(2.0 * (taper * signal) @ np.exp(-1j * phase) / taper.sum())


def _frequency(signal: Array, t: Array, taper: Array, line: float) -> float:
    """The frequency [Hz] no further than a line from one at which a signal is largest. line [Hz]."""
    near = 1.0 / (len(t) * (t[1] - t[0]))
    found = minimize_scalar(
        lambda f: -abs(_along(signal, taper, 2 * np.pi * f * t)), bounds=(line - near, line + near), method="bounded"
    )
    return float(found.x)


def _fitted(signal: Array, record: Record, taper: Array, frequency: float) -> Tone:
    """The tone of this frequency [Hz] in a signal of a record (n,)."""
    t = record.t
    found = _along(signal, taper, 2 * np.pi * frequency * t)
    return Tone(record.name, float(t[0]), float(t[-1]), frequency, found.real, -found.imag)


def _follows_the_angle(left: Array, record: Record, taper: Array, frequency: float) -> bool:
    """Whether what looks like a tone in the residual keeps in step with the motor's angle nearly as well as with time:
    at one of the speeds of the record an effect that is periodic in the angle makes it."""
    n, angle = len(left), record.phi_m - record.phi_m.min()
    fastest = FASTER * float(np.quantile(np.abs(record.dphi_m), 1.0 - RARE))
    if not (fastest > 0.0 and angle.max() > 0.0):
        return False
    spectrum, k = np.fft.rfft(left), round(frequency * n * record.sampling_time)
    spectrum[: max(0, k - NEAR)] = spectrum[k + NEAR + 1 :] = 0.0
    narrow = taper * np.fft.irfft(spectrum, n)
    slowest = fastest / SPEEDS
    bins = np.pi * slowest / (2.0 * 2.0 * np.pi * frequency)  # half of the shortest period, twice over
    count = int(angle.max() / bins) + 1
    by_angle = np.bincount((angle / bins).astype(np.intp), narrow, count)
    lines = np.abs(np.fft.rfft(by_angle, 4 * count)) / np.abs(_along(left, taper, 2 * np.pi * frequency * record.t))
    periods = 2 * np.pi * np.fft.rfftfreq(4 * count, bins)  # [1/rad]
    likely = (periods * fastest >= 2 * np.pi * frequency) & (periods * slowest <= 2 * np.pi * frequency)
    return bool(np.any(2.0 * lines[likely] / taper.sum() > np.sqrt(IN_STEP)))
