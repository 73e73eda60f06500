"""Periods in the misfit: how often a turn an effect that goes round with an angle would have to repeat itself.

A grid cannot hold them: a record of many turns tells numbers of periods apart that lie closer than any grid. What the
residual gains from a torque at each sample, found by one adjoint solve, is summed over the angle to a spectrum, and the
spectrum's peaks are scored beside the grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import scipy
from scipy.ndimage import median_filter

from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.scoring.candidates import Candidate
from robotid.diagnosis.scoring.columns import as_measured, felt
from robotid.model.array import Array
from robotid.model.port import Port
from robotid.model.term import MotionTransform, Term
from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory

COORDINATES = {Port.MOTOR: 0, Port.ARM: 1}
"""On which a plain torque at a port acts."""
PEAKS = 3  # that are tried, of the highest and of the most prominent
FINE, PADDED = 16, 4  # bins in the shortest period; points of the spectrum in its resolution
SHIFT = 1  # points of the spectrum by which what the fit has taken may shift a high peak
MOST_BINS = 2**21
SURROUNDINGS = 101  # points of the spectrum that a peak must stand out from


def periods(
    missing: Sequence[Candidate], trial: RefittedModel, records: Sequence[Record], gradients: Sequence[Array]
) -> tuple[Candidate, ...]:
    """More points for the candidates that go round with an angle, at the peaks of the misfit's spectrum. gradients
    (nv, n) : what the residual of each record gains from a generalised force."""
    round_ = {c.name: c for c in missing if _counted(c) is not None}
    return tuple(new for c in round_.values() for new in _at_peaks(c, trial, records, gradients))


def _counted(candidate: Candidate) -> int | None:
    """The parameter that counts periods, of a plain torque on one coordinate or of teeth that go with the motor."""
    effect = candidate.effect
    plain = candidate.place in COORDINATES and not isinstance(effect, MotionTransform)
    if not isinstance(effect, Term) or effect.states or not (plain or _meshes(effect)):
        return None
    return next((k for k, p in enumerate(effect.parameters) if p.turns), None)


def _meshes(effect: Term) -> bool:
    return isinstance(effect, MotionTransform) and effect.watches is Port.MOTOR


def _at_peaks(
    candidate: Candidate, trial: RefittedModel, records: Sequence[Record], gradients: Sequence[Array]
) -> Iterator[Candidate]:
    k = _counted(candidate)
    assert k is not None
    moved = map(as_measured, trial.motions.fitted, records)
    waves = [_wave(candidate, k, *case) for case in zip(moved, gradients, strict=True)]
    angles, weights = (np.concatenate(parts) for parts in zip(*waves, strict=True))
    for n in _peaks(angles, weights, candidate.effect.parameters[k].grid):
        yield candidate.at(k, n)


def _wave(candidate: Candidate, k: int, trajectory: Trajectory, gradient: Array) -> tuple[Array, Array]:
    """The angle that the effect goes round with, and what the residual gains from a wave of no periods, (n,) each."""
    assert isinstance(candidate.effect, Term)
    if _meshes(candidate.effect):  # little but the twist of a stiff gear: a torque between motor and arm
        return trajectory.phi_m, trajectory.joint.ratio * gradient[0] - gradient[1]
    flat = candidate.at(k, 0.0)
    [place], [m] = felt(trajectory, [flat])
    partials = place.term.partials(m, flat.values).theta
    factor = sum((np.asarray(partials[i]) for i in flat.scored), np.zeros(gradient.shape[1]))
    return m.x, factor * gradient[COORDINATES[place.port]]


def _peaks(angle: Array, weight: Array, grid: Sequence[float]) -> Iterator[float]:
    """Numbers of periods a turn, within the grid's range, at which the sum of weight exp(i n angle) peaks."""
    low, span = float(angle.min()), float(np.ptp(angle))
    if span <= 0.0:
        return
    bins = 2 ** int(np.ceil(np.log2(max(2.0, FINE * max(grid) * span / (2 * np.pi)))))
    if bins * PADDED > MOST_BINS:
        return
    at = np.minimum(((angle - low) * (bins / span)).astype(int), bins - 1)
    power = np.abs(np.fft.rfft(np.bincount(at, weight, bins), PADDED * bins)) ** 2
    n = 2 * np.pi * np.arange(len(power)) / (PADDED * span)
    inside = (n >= max(min(grid), np.pi / span)) & (n <= max(grid))
    standing = power / np.maximum(median_filter(power, SURROUNDINGS), 1e-300)
    found, _ = scipy.signal.find_peaks(np.where(inside, power, 0.0))
    highest, prominent = (sorted(found, key=lambda i: -value[i])[:PEAKS] for value in (power, standing))
    chosen = {int(i) + shift for i in highest for shift in (-SHIFT, 0, SHIFT)} | {int(i) for i in prominent}
    yield from (float(n[i]) for i in sorted(chosen) if 0 < i < len(n))
