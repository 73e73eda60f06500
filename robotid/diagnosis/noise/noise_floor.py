"""The noise floor: what of a residual is noise of the measured output and of the recorded torque.

The spectrum distinguishes it from a misfit. The noises have known shapes, while a misfit fills the lower frequencies:
the lowest frequency is sought from which the spectrum is that of noise. Quantisation of an encoder counts as noise.
Where the experiment repeats, the difference between its periods shows the noise alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.noise.settings import NOISE
from robotid.diagnosis.noise.spectrum import (
    Spectrum,
    segment_spectrum,
    steady_spectrum,
    whittle,
)
from robotid.estimate.covariance import ABSORBED
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.levels import KINSHIP, likeliest_in_common
from robotid.model.array import Array
from robotid.signals.record import Quantity


@dataclass(frozen=True, slots=True)
class Noise:
    """The noise in a residual.

    output : standard deviation of the noise of the output, in its unit; torque : of the noise of the recorded torque
    [Nm]; floor : RMS error that both cause; alone : nothing but noise is to be seen.
    """

    output: float
    torque: float
    floor: float
    alone: bool


@dataclass(frozen=True, slots=True)
class Levels:
    """Variances of output and torque noise that explain the spectrum of a residual from octave `band` upwards; alone :
    they explain all of what they were taken from."""

    output: float
    torque: float
    band: int
    alone: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Shown:
    """The levels of one segment: seen in the spectrum `of_residual`, read off the spectrum `source`."""

    levels: Levels
    of_residual: Spectrum
    source: Spectrum


def noise_levels(segments: Sequence[SimulatedSegment], output: Quantity) -> tuple[Noise, ...]:
    """The noise of every segment's residual. That of the torque is the same in all, and taken from where it shows
    best."""
    shown = [_best_levels(one, output) for one in segments]
    torque = _common_torque_variance(shown)
    return tuple(_noise(one.of_residual, one.levels, torque) for one in shown)


def _common_torque_variance(shown: Sequence[_Shown]) -> float:
    """Variance of the torque's noise: that of the segment that shows least of it, or more where segments of nothing but
    noise agree on it and a misfit leaves room for it in the others. In one segment alone a misfit may pass for it."""
    noise = [one.source for one in shown if one.levels.alone]
    least = min(one.levels.torque for one in shown)
    if len(noise) < 2 or not all(seen.power.any() for seen in noise):
        return least
    torque = _agreed_torque_variance(noise)
    rooms = [_room_for_torque(one.source, one.levels.output, torque) for one in shown if not one.levels.alone]
    return max(least, min([torque, *rooms]))


def _agreed_torque_variance(noise: Sequence[Spectrum]) -> float:
    """Variance of the torque's noise with which an output noise of its own explains each spectrum, 0 without any."""
    powers, shapes = zip(*((seen.power[ABSORBED:], seen.shapes[:, ABSORBED:]) for seen in noise), strict=True)
    sensors = [one[0] for one in shapes]
    levels, (torque,), cost = likeliest_in_common(powers, sensors, [one[1:] for one in shapes])
    *_, cost_without = likeliest_in_common(powers, sensors, [one[:0] for one in shapes])
    agree = all(
        seen.explained_by(np.array([level, torque]) @ seen.shapes, seen.bands)
        for seen, level in zip(noise, levels, strict=True)
    )
    return float(torque) if agree and cost_without - cost > NOISE.torque_hint else 0.0


def _room_for_torque(seen: Spectrum, output: float, torque: float) -> float:
    """The largest variance of the torque's noise, up to `torque`, for which a spectrum has room beside the output's: a
    misfit can only add to what noise does in a band, where that depends on the torque at all."""
    wide = [band for band in seen.bands if band.stop - band.start >= NOISE.min_band_lines]
    parts = (seen.power, output * seen.shapes[0], seen.response)
    power, sensed, response = (np.array([part[band].mean() for band in wide]) for part in parts)
    telling = torque * response > NOISE.hidden_share * sensed
    if seen.weight is not None:
        # an angle's response falls so steeply that a border band with a little too little power would leave no room
        lines = np.array([band.stop - band.start for band in wide])
        power = power * (1.0 + NOISE.band_surprise * np.sqrt(KINSHIP / lines))
    return max(0.0, float(np.min((power - sensed)[telling] / response[telling], initial=torque)))


def _best_levels(segment: SimulatedSegment, output: Quantity) -> _Shown:
    """From the residual as a whole where it is noise; else from what shows the noise best, and the spectrum of that."""
    record, residual = segment.record, segment.residual
    whole = segment_spectrum(segment, output)
    levels, source = spectrum_levels(whole), whole
    period = round(record.period / record.sampling_time) if record.period else len(residual)
    if not levels.alone and 2 * period <= len(residual):
        settled = residual[period if 3 * period <= len(residual) else 0 :]
        difference = (settled[period:] - settled[:-period]) / np.sqrt(2.0)
        if difference.any():  # a coarse encoder may show the same steps in all periods
            source = segment_spectrum(segment, output, difference)
            levels = replace(spectrum_levels(source), band=levels.band)
    if not levels.alone and len(residual) >= 2 * NOISE.min_band_lines * NOISE.record_parts:
        steady = spectrum_levels(steady_spectrum(whole, residual))
        levels = replace(levels, torque=min(levels.torque, steady.torque))
    return _Shown(levels, whole, source)


def spectrum_levels(seen: Spectrum) -> Levels:
    """The levels of output and torque noise that explain a spectrum from the lowest octave that they can."""
    bands = seen.bands
    if not seen.power.any():
        return Levels(0.0, 0.0, 0, True)
    for k in range(max(1, len(bands) - 2)):
        above = slice(bands[k].start, None)
        shapes = seen.shapes[:, above]
        levels, cost = whittle(seen.power[above], shapes)
        if seen.explained_by(levels @ seen.shapes, bands[k:]):
            break
    else:
        k += 1
    alone, cost_alone = whittle(seen.power[above], shapes[:1])
    level, torque = (alone[0], 0.0) if cost_alone - cost < NOISE.torque_evidence else levels
    quietest = min(float(seen.power[band].mean() / seen.shapes[0, band].mean()) for band in bands)
    level = max(float(level), NOISE.hidden_share * quietest)
    torque = _room_for_torque(seen, level, float(torque)) if k > 0 else torque
    return Levels(level, float(torque), k, k == 0)


def _noise(seen: Spectrum, levels: Levels, torque: float) -> Noise:
    """A noise is not larger than what is seen, and of the torque's a fit takes what is in the lowest frequencies."""
    alone, shown = levels.band == 0, 1.0 if seen.weight is None else seen.weight
    density: Array = np.array([levels.output, torque]) @ seen.shapes
    # an encoder's errors gather where the motor moves, and the taper shows other parts of a record more than its ends
    tapered, untapered = np.sum(shown * density), np.sum(shown * (levels.output + torque * seen.response))
    density[:ABSORBED] = np.minimum(density, seen.power)[:ABSORBED] if alone else density[ABSORBED]
    density, power = shown * density, shown * seen.power
    sums = [(density[band].sum(), power[band].sum()) for band in (slice(ABSORBED), *seen.bands)]
    total = sum(expected if alone else min(expected, found) for expected, found in sums)
    share = untapered / tapered if tapered > 0.0 else 1.0
    floor = np.sqrt(share * min(total, power.sum()) / len(density))
    return Noise(float(np.sqrt(levels.output)), float(np.sqrt(torque)), float(floor), alone)
