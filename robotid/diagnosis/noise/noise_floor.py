"""The error that no model can remove: noise of the measured output, and the joint's response to noise of its torque.

Told from a misfit by the spectrum. Both noises are white where they arise, so the residual's spectrum is a constant
plus a multiple of the joint's squared response (Whittle 1953), while a misfit fills the lower frequencies: the lowest
frequency is sought from which the spectrum is that of noise. Quantisation of an encoder counts as noise. Where the
experiment repeats, the difference between its periods shows the noise alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from scipy.optimize import nnls

from robotid.estimate.covariance import ABSORBED, impulse_response, zero_order_hold_response
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array
from robotid.signals.record import Quantity
from robotid.simulation.trajectory import Trajectory

SCORING = 20  # steps of Fisher scoring at most
SETTLED = 1e-6  # relative change of the levels
TIE = 1e-12  # of one line: keeps spectra apart that are the same
KINSHIP = 35 / 18  # neighbouring frequencies per independent one under a Hann taper
SURPRISE = 4.0  # standard deviations of a band's mean that pass for chance
EVIDENCE = 10.0  # twice the gain in log-likelihood that proves a torque noise beside a misfit
HINT = 4.0  # the same where there is none: less caution, for noise that is overlooked is taken for an effect
PARTS = 8  # of a record, some of them without reversals
SHORTEST = 512  # samples that can be divided further
FEW = 32  # frequencies of a band too narrow to bound a level
LINES = 4096  # frequencies whose matrices are in memory at once
DARK = 0.1  # of the quietest band: output noise where the torque's hides it


@dataclass(frozen=True, slots=True)
class Noise:
    """output : standard deviation of the noise of the output; torque : of the recorded torque [Nm]; floor : RMS error
    that both cause; whole : nothing but noise is to be seen."""

    output: float
    torque: float
    floor: float
    whole: bool


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Periodogram of a residual and squared response of the joint to its torque, (m,) each, at the same frequencies."""

    power: Array
    response: Array

    @property
    def bands(self) -> list[slice]:
        """Octaves, above the lowest frequencies, which a fit shapes."""
        edges, m = [ABSORBED], len(self.power)
        while 2 * edges[-1] <= m // 2:
            edges.append(2 * edges[-1])
        return [slice(a, b) for a, b in zip(edges, [*edges[1:], m], strict=True)]


@dataclass(frozen=True, slots=True)
class Levels:
    """Variances of output and torque noise. band : the octave from which they explain the residual's spectrum; sure :
    they explain all of what they were taken from."""

    output: float
    torque: float
    band: int
    sure: bool


def noise_levels(segments: Sequence[SimulatedSegment], output: Quantity) -> tuple[Noise, ...]:
    """Noise in every residual (n,). That of the torque is the same in all, and taken from where it shows best."""
    spectra = [spectrum(one.trajectory, one.residual, output) for one in segments]
    found = [_best(one, seen, output) for one, seen in zip(segments, spectra, strict=True)]
    torque = _torque(found)
    return tuple(_noise(seen, levels, torque) for seen, (levels, _) in zip(spectra, found, strict=True))


def _torque(found: Sequence[tuple[Levels, Spectrum]]) -> float:
    """Variance of the torque's noise: that of the record that shows least of it, or more where records of nothing but
    noise agree on it and a misfit leaves room for it in the others. In one record alone a misfit may pass for it."""
    noise = [seen for levels, seen in found if levels.sure]
    least = min(levels.torque for levels, _ in found)
    if len(noise) < 2 or not all(seen.power.any() for seen in noise):
        return least
    torque = _agreed(noise)
    return max(least, min([torque, *(_room(seen, levels.output, torque) for levels, seen in found if not levels.sure)]))


def _agreed(noise: Sequence[Spectrum]) -> float:
    """Variance of the torque's noise with which an output noise of its own explains each spectrum, 0 without any."""
    above = [(seen.power[ABSORBED:], seen.response[ABSORBED:]) for seen in noise]
    power, response = (np.concatenate(parts) for parts in zip(*above, strict=True))
    own = np.repeat(np.eye(len(above)), [len(part) for part, _ in above], axis=1)
    (*levels, torque), cost = whittle(power, np.vstack([own, response]))
    _, dearer = whittle(power, own)
    models = [level + torque * seen.response for level, seen in zip(levels, noise, strict=True)]
    agree = all(_explains(seen.power, model, seen.bands) for seen, model in zip(noise, models, strict=True))
    return float(torque) if agree and dearer - cost > HINT else 0.0


def _room(seen: Spectrum, level: float, torque: float) -> float:
    """The largest variance of the torque's noise, up to `torque`, for which a spectrum has room beside the output's: a
    misfit can only add to what noise does in a band, where that tells of the torque at all."""
    wide = [band for band in seen.bands if band.stop - band.start >= FEW]
    power, response = (np.array([part[band].mean() for band in wide]) for part in (seen.power, seen.response))
    telling = torque * response > DARK * level
    return max(0.0, float(np.min((power - level)[telling] / response[telling], initial=torque)))


def spectrum(trajectory: Trajectory, residual: Array, output: Quantity) -> Spectrum:
    """Under a Hann taper, lest a slow drift leaks into all frequencies."""
    n, row = len(residual), trajectory.joint.output_row(output)
    taper = scipy.signal.windows.hann(n + 2)[1:-1]
    if output == "position":
        response = _squared_response(trajectory, row, n)
    else:
        impulse = impulse_response(trajectory.joint, trajectory.theta, row, trajectory.sampling_time, n)
        response = (np.abs(np.fft.rfft(impulse, 2 * n)) ** 2)[::2]
    return Spectrum(np.abs(np.fft.rfft(taper * residual)) ** 2 / np.sum(taper**2), response)


def _squared_response(trajectory: Trajectory, row: int, n: int) -> Array:
    """Of state `row` to a torque that is held, at the frequencies of n samples; without end, that of a position does
    not fade, as a speed's does. Where a steady torque drives it away, the lowest frequency stands for none."""
    A, b = zero_order_hold_response(trajectory.joint, trajectory.theta, trajectory.sampling_time)
    z = np.exp(2j * np.pi * np.arange(1, n // 2 + 1) / n)
    found = [
        np.linalg.solve(part[:, None, None] * np.eye(len(b)) - A, b[:, None])[:, row, 0]
        for part in np.array_split(z, len(z) // LINES + 1)
    ]
    squared = np.abs(np.concatenate(found)) ** 2
    return np.concatenate([squared[:1], squared])


def steady(seen: Spectrum, residual: Array) -> Spectrum:
    """The spectrum that half the time stays below (Welch 1967, with medians): bursts, as at reversals, do not show."""
    frequency, power = scipy.signal.welch(residual, nperseg=len(residual) // PARTS, detrend=False, average="median")
    return Spectrum(power / 2, np.interp(frequency, np.linspace(0, 0.5, len(seen.response)), seen.response))


def _best(segment: SimulatedSegment, seen: Spectrum, output: Quantity) -> tuple[Levels, Spectrum]:
    """From the residual as a whole where it is noise; else from what shows the noise best, and the spectrum of that."""
    record, residual = segment.record, segment.residual
    levels, shown = _levels(seen), seen
    period = round(record.period / record.sampling_time) if record.period else len(residual)
    if not levels.sure and 2 * period <= len(residual):
        settled = residual[period if 3 * period <= len(residual) else 0 :]
        difference = (settled[period:] - settled[:-period]) / np.sqrt(2.0)
        shown = spectrum(segment.trajectory, difference, output)
        levels = replace(_levels(shown), band=levels.band)
    if not levels.sure and len(residual) >= SHORTEST:
        levels = replace(levels, torque=min(levels.torque, _levels(steady(seen, residual)).torque))
    return levels, shown


def _levels(seen: Spectrum) -> Levels:
    bands = seen.bands
    if not seen.power.any():
        return Levels(0.0, 0.0, 0, True)
    for k in range(max(1, len(bands) - 2)):
        above = slice(bands[k].start, None)
        both = np.stack([np.ones_like(seen.response), seen.response])[:, above]
        levels, cost = whittle(seen.power[above], both)
        if _explains(seen.power, levels[0] + levels[1] * seen.response, bands[k:]):
            break
    else:
        k += 1
    alone, dearer = whittle(seen.power[above], both[:1])
    level, torque = (alone[0], 0.0) if dearer - cost < EVIDENCE else levels
    level = max(float(level), DARK * min(float(seen.power[band].mean()) for band in bands))
    torque = _room(seen, level, float(torque)) if k > 0 else torque
    return Levels(level, float(torque), k, k == 0)


def whittle(power: Array, bases: Array) -> tuple[Array, float]:
    """Levels (k,) >= 0 of bases (k, m) that explain a periodogram (m,) best, and minus twice the log-likelihood."""
    size = bases.mean(axis=1, keepdims=True)
    bases = bases / size
    model, least, before = np.full(len(power), power.mean()), 1e-12 * power.mean(), np.zeros(len(bases))
    for _ in range(SCORING):
        weighted = bases / model
        root = np.linalg.cholesky(weighted @ weighted.T + TIE * np.eye(len(bases)))
        levels, _ = nnls(root.T, np.linalg.solve(root, weighted @ (power / model)))
        model = np.maximum(levels @ bases, least)
        if np.abs(levels - before).max() <= SETTLED * levels.max():
            break
        before = levels
    return levels / size[:, 0], 2 / KINSHIP * float(np.sum(np.log(model) + power / model))


def _explains(power: Array, model: Array, bands: Sequence[slice]) -> bool:
    """Whether every band's mean over its model is one, but for chance."""
    count = np.array([band.stop - band.start for band in bands])
    ratio = np.array([np.mean(power[band] / np.maximum(model[band], 1e-300)) for band in bands])
    return bool(np.all(np.abs(ratio - 1) * np.sqrt(count / KINSHIP) < SURPRISE))


def _noise(seen: Spectrum, levels: Levels, torque: float) -> Noise:
    """A noise is not larger than what is seen, and of the torque's a fit takes what is in the lowest frequencies."""
    whole = levels.band == 0
    density = levels.output + torque * seen.response
    density[:ABSORBED] = np.minimum(density, seen.power)[:ABSORBED] if whole else density[ABSORBED]
    sums = [(density[band].sum(), seen.power[band].sum()) for band in (slice(ABSORBED), *seen.bands)]
    total = sum(model if whole else min(model, power) for model, power in sums)
    floor = np.sqrt(min(total, seen.power.sum()) / len(density))
    return Noise(float(np.sqrt(levels.output)), float(np.sqrt(torque)), float(floor), whole)
