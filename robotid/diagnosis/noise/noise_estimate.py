"""The noise that a diagnosis reckons with: that of the sensors, and torque errors that nothing known explains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from robotid.diagnosis.noise.colour import coloured_noise
from robotid.diagnosis.noise.noise_floor import Noise, noise_levels
from robotid.diagnosis.noise.settings import NOISE
from robotid.diagnosis.noise.spectrum import likeliest_levels, segment_spectrum
from robotid.diagnosis.noise.whitening import Segment, sensed_variance, whitening
from robotid.estimate.covariance import ABSORBED
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.whitening import NoiseLevels, innovations_filter
from robotid.model.array import Array
from robotid.signals.record import Quantity

SHORT = 0.1  # of the samples of segments: where more columns than that are taken out of them, what is slow goes, too

TorqueErrors = Literal["white", "coloured"] | None
"""What counts as errors of the torque: white ones, white and red ones, or none."""


@dataclass(frozen=True, slots=True, eq=False)
class NoiseEstimate:
    """segments : the records with the filters that whiten their noise; reached : all known effects and free curves
    together leave no more than the noise of the sensors."""

    segments: tuple[Segment, ...]
    reached: bool


@dataclass(frozen=True, slots=True)
class Variances:
    """Variance of each segment's output noise, in the unit of the output squared, and of the torque's noise [Nm2]."""

    output: tuple[float, ...]
    torque: float


@dataclass(frozen=True, slots=True, eq=False)
class Explained:
    """What may explain the residuals of segments: columns (m, n) of each, and left : what these do not explain."""

    columns: tuple[Array, ...]
    left: tuple[SimulatedSegment, ...]


def estimate_noise(
    segments: Sequence[SimulatedSegment],
    known: Explained,
    with_curves: Callable[[], Explained],
    output: Quantity,
    *,
    torque_errors: TorqueErrors = None,
) -> NoiseEstimate:
    """The whitening of every segment, and whether the noise of the sensors can be reached.

    known : by all candidates; with_curves : gives the same by these and free curves, if need be. torque_errors :
    whether to assume errors of the torque. What even all candidates and free curves leave beyond the sensors' noise may
    count as such, white and red, as large as it takes, lest its every detail be explained.
    """
    sensors = _of_sensors(segments, output)
    if _excess(known.left, output, sensors) > NOISE.unexplained_energy:
        known = with_curves()
    reached = is_reached(_excess(known.left, output, sensors), _excess(segments, output, sensors))
    if torque_errors == "coloured":
        return NoiseEstimate(_coloured_as_left(segments, known, output, sensors), reached)
    white = torque_errors == "white" and not reached
    variances = _white_as_left(known, output, sensors) if white else sensors
    return NoiseEstimate(_whitened(segments, output, variances), reached)


def sensor_noise(segments: Sequence[SimulatedSegment], output: Quantity) -> tuple[Segment, ...]:
    """The whitening of every segment by the noise of the sensors, as it shows in the residuals."""
    return _whitened(segments, output, _of_sensors(segments, output))


def _of_sensors(segments: Sequence[SimulatedSegment], output: Quantity) -> Variances:
    noise = noise_levels(segments, output)
    return Variances(output_variances(noise), noise[0].torque ** 2)  # the torque's is the same in all


def output_variances(noise: Sequence[Noise]) -> tuple[float, ...]:
    """Variance of each segment's output noise; one that shows much less than the others, or none, was at rest."""
    typical = float(np.median([one.output for one in noise if one.output > 0.0] or [0.0]))
    return tuple(max(one.output, NOISE.rest_share * typical) ** 2 for one in noise)


def is_reached(left: float, before: float) -> bool:
    """Whether the noise of the sensors is reached, where so much energy is left and was there before, over that of the
    noise: of a large misfit linear columns leave some."""
    return left <= max(NOISE.unexplained_energy, min(NOISE.linear_share * before, NOISE.max_linear_energy))


def _white_as_left(known: Explained, output: Quantity, sensors: Variances) -> Variances:
    """Noises as large as what is left shows them, none smaller than the sensors' own (Whittle 1953)."""
    left, columns = known.left, known.columns
    found = []
    for one in left:
        seen = segment_spectrum(one, output)
        found.append(likeliest_levels(seen.power[ABSORBED:], seen.shapes[:, ABSORBED:]))
    typical = float(np.median([f[0] for f in found]))
    least = NOISE.rest_share**2 * typical
    raised = tuple(max(level, float(f[0]), least) for level, f in zip(sensors.output, found, strict=True))
    torques = [float(f[1]) for f in found]
    if sum(map(len, columns)) > SHORT * sum(len(one.residual) for one in left):
        # they take what is slow, and a segment that shows none of it tells nothing
        torques = [level for level in torques if level > 0.0] or [0.0]
    most = max(sensors.torque, float(np.median(torques)))
    return Variances(raised, _sufficient_torque(left, output, Variances(raised, sensors.torque), most))


def _sufficient_torque(left: Sequence[SimulatedSegment], output: Quantity, least: Variances, most: float) -> float:
    """The variance of the torque error with which what is left has the energy of noise, and no more than most."""

    def excess(torque: float) -> float:
        return _excess(left, output, Variances(least.output, torque))

    return sufficient_variance(excess, least.torque, most)


def sufficient_variance(excess: Callable[[float], float], least: float, most: float) -> float:
    """The variance at which an energy over that of the noise, which falls with it, is one; no more than `most`."""
    if most <= 0.0 or excess(most) >= 1.0:
        return most
    low, high = np.log(max(least, NOISE.min_variance_ratio * most)), np.log(most)
    while high - low > NOISE.variance_resolution:
        middle = (low + high) / 2
        low, high = (low, middle) if excess(float(np.exp(middle))) < 1.0 else (middle, high)
    return float(np.exp(high))


def _coloured_as_left(
    segments: Sequence[SimulatedSegment], known: Explained, output: Quantity, sensors: Variances
) -> tuple[Segment, ...]:
    """Noises as large as what is left shows them, none smaller than the sensors' own."""
    noise, found = coloured_noise(segments, known.columns, output), []
    for one, residual, variance in zip(noise.segments, noise.residuals, sensors.output, strict=True):
        levels, least = one.whitening.levels, sensed_variance(one.record, output, variance)
        levels = replace(levels, output=max(levels.output, least), torque=max(levels.torque, sensors.torque))
        found.append(Segment(one.record, innovations_filter(residual.response, levels)))
    return tuple(found)


def _whitened(segments: Sequence[SimulatedSegment], output: Quantity, variances: Variances) -> tuple[Segment, ...]:
    found = []
    for one, level in zip(segments, variances.output, strict=True):
        t = one.trajectory
        levels = NoiseLevels(sensed_variance(one.record, output, level), variances.torque)
        found.append(Segment(one.record, whitening(t.joint, t.theta, output, one.record, levels)))
    return tuple(found)


def _excess(left: Sequence[SimulatedSegment], output: Quantity, variances: Variances) -> float:
    """Energy of what is left, over that of the noise."""
    pairs = zip(_whitened(left, output, variances), left, strict=True)
    energy = sum(segment.energy(one.residual) for segment, one in pairs)
    return energy / sum(len(one.residual) for one in left)
