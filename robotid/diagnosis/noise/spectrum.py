"""The spectrum of a residual, as a sum of noises whose shapes are known where they arise.

White noise of the output is flat; white noise of the recorded torque has the shape of the joint's squared response; an
encoder's follows from the motion. Where a speed is derived from an angle, the spectrum is that of the angle, in which
the sensor's white noise is flat.
Levels of such shapes are found by Whittle's likelihood (Whittle 1953).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from scipy.optimize import nnls

from robotid.diagnosis.noise.quantisation import quantisation_spectrum
from robotid.diagnosis.noise.settings import NOISE
from robotid.estimate.covariance import ABSORBED, impulse_response, zero_order_hold_response
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.levels import KINSHIP
from robotid.estimate.noise.response import torque_response
from robotid.model.array import Array
from robotid.signals.derivation import Derivation
from robotid.signals.record import Quantity
from robotid.simulation.trajectory import Trajectory

ALIKE = 1e-12  # of the sum of their information: by so much do two spectra that are the same differ at least
LINES = 4096  # frequencies whose matrices are in memory at once: any number gives the same spectrum
LEAST = 1e-30  # of the mean power: a model that leaves a line without any, as one of no noise does


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Periodogram of a residual and squared response of the joint to its torque, (m,) each, at the same frequencies.

    sensor (m,) : spectrum of the sensor's noise of unit variance, as it shows under the taper; None, and it has the
    same level at every frequency. weight (m,) : by which the output shows these spectra, its mean over the frequencies
    one; None, and it shows them as they are.
    """

    power: Array
    response: Array
    weight: Array | None = None
    sensor: Array | None = None

    @property
    def shapes(self) -> Array:
        """Spectra of unit noise of the output and of the torque, (2, m)."""
        return np.stack([np.ones_like(self.response) if self.sensor is None else self.sensor, self.response])

    @property
    def bands(self) -> list[slice]:
        """Octaves, above the lowest frequencies, which a fit shapes."""
        edges, m = [ABSORBED], len(self.power)
        while 2 * edges[-1] <= m // 2:
            edges.append(2 * edges[-1])
        return [slice(a, b) for a, b in zip(edges, [*edges[1:], m], strict=True)]

    def explained_by(self, model: Array, bands: Sequence[slice]) -> bool:
        """Whether the mean of every band over that of a model (m,) is one, but for chance."""
        count = np.array([band.stop - band.start for band in bands])
        ratio = np.array([np.mean(self.power[band] / np.maximum(model[band], 1e-300)) for band in bands])
        return bool(np.all(np.abs(ratio - 1) * np.sqrt(count / KINSHIP) < NOISE.band_surprise))


def residual_spectrum(
    trajectory: Trajectory, residual: Array, output: Quantity, derivation: Derivation | None = None
) -> Spectrum:
    """Spectrum of a residual (n,) along a trajectory, under a Hann taper, lest a slow drift leaks everywhere.

    derivation : of a derived speed, whose spectrum is divided by that of the difference. The angle itself would leak.
    """
    n, row = len(residual), trajectory.joint.output_row(output)
    taper = scipy.signal.windows.hann(n + 2)[1:-1]
    weight = None
    if derivation is not None:
        omega = 2 * np.pi * np.arange(n // 2 + 1) / n
        t = trajectory
        through = torque_response(t.joint, t.theta, t.sampling_time, output, derivation).squared(omega[1:])
        response = derivation.gain * np.concatenate([through[:1], through])
        weight = _tapered(derivation.squared(omega) / derivation.gain)
    elif output == "position" or _runs_away(trajectory, n):
        response = _squared_response(trajectory, row, n)
    else:
        impulse = impulse_response(trajectory.joint, trajectory.theta, row, trajectory.sampling_time, n)
        response = np.abs(np.fft.rfft(impulse)) ** 2
    power = np.abs(np.fft.rfft(taper * residual)) ** 2 / np.sum(taper**2)
    return Spectrum(power if weight is None else power / weight, response, weight)


def segment_spectrum(segment: SimulatedSegment, output: Quantity, residual: Array | None = None) -> Spectrum:
    """Spectrum of a segment's residual, or of another (n,) of the same motion, in which an encoder has the noise that
    follows from the motion."""
    residual, record = segment.residual if residual is None else residual, segment.record
    seen = residual_spectrum(segment.trajectory, residual, output, Derivation.of(record, output))
    encoder = quantisation_spectrum(record, output)
    if encoder is None:
        return seen
    fine, own = (np.linspace(0.0, 0.5, m) for m in (len(seen.power), len(encoder)))
    return replace(seen, sensor=np.interp(fine, own, encoder))


def _tapered(spectrum: Array) -> Array:
    """A spectrum (m,) as it shows under a Hann taper, which lets neighbouring frequencies into each: not even at the
    zeros of a difference is there nothing."""
    padded = np.concatenate([spectrum[1:2], spectrum, spectrum[-2:-1]])
    return np.asarray(np.convolve(padded, [1 / 6, 2 / 3, 1 / 6], mode="valid"))


def _runs_away(trajectory: Trajectory, n: int) -> bool:
    """Whether the linear joint is unstable, so that its answer to an impulse grows over n samples."""
    A, _ = zero_order_hold_response(trajectory.joint, trajectory.theta, trajectory.sampling_time)
    return bool(n * np.log(max(1.0, float(np.abs(np.linalg.eigvals(A)).max()))) > 1.0)


def _squared_response(trajectory: Trajectory, row: int, n: int) -> Array:
    """Squared response of state `row` to a torque that is constant over each interval, at the frequencies of n samples.

    Without end, for that of a position does not fade as a speed's does. Where a steady torque drives it away, the
    lowest frequency stands for none.
    """
    A, b = zero_order_hold_response(trajectory.joint, trajectory.theta, trajectory.sampling_time)
    z = np.exp(2j * np.pi * np.arange(1, n // 2 + 1) / n)
    found = [
        np.linalg.solve(part[:, None, None] * np.eye(len(b)) - A, b[:, None])[:, row, 0]
        for part in np.array_split(z, len(z) // LINES + 1)
    ]
    squared = np.abs(np.concatenate(found)) ** 2
    return np.concatenate([squared[:1], squared])


def steady_spectrum(seen: Spectrum, residual: Array) -> Spectrum:
    """The spectrum that half the time stays below (Welch 1967, with medians): bursts, as at reversals, do not show."""
    length = len(residual) // NOISE.record_parts
    frequency, power = scipy.signal.welch(residual, nperseg=length, detrend=False, average="median")
    fine = np.linspace(0, 0.5, len(seen.response))
    if seen.weight is not None:
        power = power / _tapered(np.interp(frequency, fine, seen.weight))
    sensor = None if seen.sensor is None else np.interp(frequency, fine, seen.sensor)
    return Spectrum(power / 2, np.interp(frequency, fine, seen.response), sensor=sensor)


def whittle(power: Array, shapes: Array) -> tuple[Array, float]:
    """Levels (k,) >= 0 of shapes (k, m) that explain a periodogram (m,) best, and minus twice the log-likelihood.

    By a few steps of Fisher scoring from a flat spectrum. Of one that falls by many orders of magnitude they may miss
    the steep part, so that a misfit does not pass for noise there; `likeliest_levels` does not. Of what is silent no
    levels are likelier than none.
    """
    scale = float(power.mean())  # what is left of rounding errors has powers whose inverse is beyond all numbers
    if scale == 0.0:
        return np.zeros(len(shapes)), 0.0
    size = shapes.mean(axis=1, keepdims=True)
    size[size <= 0.0] = 1.0  # of a joint that no torque moves
    shapes, power = shapes / size, power / scale
    model, least, before = np.full(len(power), power.mean()), 1e-12 * power.mean(), np.zeros(len(shapes))
    for _ in range(NOISE.max_fisher_steps):
        weighted = shapes / model
        information = weighted @ weighted.T
        rounding = ALIKE * np.trace(information)  # keeps spectra apart that are the same
        root = np.linalg.cholesky(information + rounding * np.eye(len(shapes)))
        levels, _ = nnls(root.T, np.linalg.solve(root, weighted @ (power / model)))
        model = np.maximum(levels @ shapes, least)
        if np.abs(levels - before).max() <= NOISE.settled_change * levels.max():
            break
        before = levels
    cost = 2 / KINSHIP * float(np.sum(np.log(model) + np.log(scale) + power / model))
    return scale * levels / size[:, 0], cost


def likeliest_levels(power: Array, shapes: Array) -> Array:
    """Levels (k,) >= 0 of shapes (k, m) at which the likelihood of a periodogram (m,) has its maximum, however steep it
    is: by Fisher scoring from where one shape alone, or equal parts of all, explain it best. None of what is silent."""
    size, scale = np.maximum(shapes.mean(axis=1, keepdims=True), 1e-300), float(power.mean())
    if scale == 0.0:
        return np.zeros(len(shapes))
    shapes, power = shapes / size, power / scale
    alone = np.diag([float(np.mean(power / np.maximum(shape, 1e-300))) for shape in shapes])
    starts = [*alone, alone.sum(axis=0) / len(shapes)]
    levels = _fisher_scored(power, shapes, min(starts, key=lambda start: deviance(power, start @ shapes)))
    return np.asarray(scale * levels / size[:, 0])


def deviance(power: Array, model: Array) -> float:
    """Minus the log-likelihood of a periodogram whose mean is a model, (m,) each, up to a constant."""
    model = np.maximum(model, LEAST * power.mean())
    return float(np.sum(np.log(model) + power / model))


def _fisher_scored(power: Array, shapes: Array, levels: Array) -> Array:
    """Levels of shapes by steps of Fisher scoring from others, each halved until it gains."""
    least, cost = LEAST * power.mean(), deviance(power, levels @ shapes)
    for _ in range(NOISE.max_fisher_steps):
        aim, share = _fisher_step(power, shapes, np.maximum(levels @ shapes, least)), 1.0
        while (after := deviance(power, (trial := levels + share * (aim - levels)) @ shapes)) > cost:
            share /= 2.0
            if share < NOISE.settled_change:
                return levels
        settled = np.all(np.abs(trial - levels) <= NOISE.settled_change * trial)
        levels, cost = trial, after
        if settled:
            break
    return levels


def _fisher_step(power: Array, shapes: Array, model: Array) -> Array:
    """Levels of shapes that explain a periodogram best by least squares, each line weighted by a model of it."""
    weighted = shapes / model
    length = np.maximum(np.linalg.norm(weighted, axis=1), 1e-300)  # levels may be orders of magnitude apart
    weighted /= length[:, None]
    root = np.linalg.cholesky(weighted @ weighted.T + ALIKE * np.eye(len(shapes)))
    levels, _ = nnls(root.T, np.linalg.solve(root, weighted @ (power / model)))
    return np.asarray(levels / length)
