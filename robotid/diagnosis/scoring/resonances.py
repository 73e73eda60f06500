"""Resonances in the misfit: the frequency at which an effect with a resonance of its own would have to ring.

A grid cannot hold it where there is so little damping that the resonance is narrower than any grid. What the residual
gains from a force at each sample is compared, frequency by frequency, with what the effect makes of the motion; where
it peaks, the effect is scored beside the grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import scipy

from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.scoring.candidates import Candidate
from robotid.diagnosis.scoring.columns import felt, with_angle
from robotid.model.array import Array
from robotid.model.term import Motion, Term
from robotid.simulation.trajectory import Trajectory

PEAKS = 2  # that are tried, the highest
POINTS = 200  # of frequency, over the range of the grid
BEYOND = 2.0  # times the grid's highest frequency: there the effect no longer moves


def resonances(missing: Sequence[Candidate], trial: RefittedModel, gradients: Sequence[Array]) -> tuple[Candidate, ...]:
    """More points for the candidates that ring. gradients (nv, n) : what the residual of each record gains from a
    generalised force."""
    alike = {(c.name, c.at(k, 0.0).values): (c, k) for c in missing if (k := _ringing(c)) is not None}
    return tuple(new for c, k in alike.values() for new in _at_peaks(c, k, trial, gradients))


def _ringing(candidate: Candidate) -> int | None:
    """The parameter that is the frequency of a resonance."""
    if not isinstance(candidate.effect, Term):
        return None
    return next((k for k, p in enumerate(candidate.effect.parameters) if p.rings), None)


def _at_peaks(candidate: Candidate, k: int, trial: RefittedModel, gradients: Sequence[Array]) -> Iterator[Candidate]:
    grid, size = candidate.effect.parameters[k].grid, candidate.effect.parameters[candidate.scored[0]]
    pairs = [_felt(candidate, with_angle(t), g) for t, g in zip(trial.motions.fitted, gradients, strict=True)]
    omega, cross = _cross_spectrum(pairs, [t.sampling_time for t in trial.motions.fitted], BEYOND * max(grid))
    points = [candidate.at(k, float(w)) for w in np.geomspace(min(grid), max(grid), POINTS)]
    gain = np.array([np.real(_response(one, omega) @ cross) for one in points])
    height = gain if size.bounds[0] == size.null else np.abs(gain)
    found, _ = scipy.signal.find_peaks(np.maximum(height, 0.0))
    yield from (points[i] for i in sorted(found, key=lambda i: -height[i])[:PEAKS])


def _felt(candidate: Candidate, trajectory: Trajectory, gradient: Array) -> tuple[Array, Array]:
    """The speed that an effect feels, and what the residual gains from a torque where it acts, (n,) each."""
    [place], [m] = felt(trajectory, [candidate])
    return m.v, sum((-c * gradient[j] for j, c in place.q), np.zeros(len(m.v)))


def _cross_spectrum(pairs: Sequence[tuple[Array, Array]], times: Sequence[float], most: float) -> tuple[Array, Array]:
    """Of all pairs of signals (n,) together, at frequencies up to `most` [rad/s]. times : their sampling times."""
    span = 2 * max(len(v) * h for (v, _), h in zip(pairs, times, strict=True))  # padded: a record is no period
    omega = np.arange(1.0, most * span / (2 * np.pi)) * (2 * np.pi / span)
    total = np.zeros(len(omega), dtype=complex)
    for (v, gain), h in zip(pairs, times, strict=True):
        n = round(span / h)
        cross = (np.conj(np.fft.rfft(gain, n)) * np.fft.rfft(v, n))[1 : len(omega) + 1]
        total[: len(cross)] += cross * h
    return omega, total


def _response(candidate: Candidate, omega: Array) -> Array:
    """Torque of the first scored parameter, per unit, to the speed that a linear, underdamped effect feels, (n,)."""
    term = candidate.effect
    assert isinstance(term, Term)
    q = len(term.states)
    units, zero = np.eye(q + 1), np.zeros(q + 1)  # the speed, and each of the states
    m = Motion(zero, units[0], zero, zero, zero, units[1:])
    rates = np.stack([np.broadcast_to(rate, (q + 1,)) for rate in term.rate(m, candidate.values)])
    torque = np.broadcast_to(term.partials(m, candidate.values).theta[candidate.scored[0]], (q + 1,))
    poles, modes = np.linalg.eig(rates[:, 1:])
    weights = (torque[1:] @ modes) * np.linalg.solve(modes, rates[:, 0])
    return np.asarray(torque[0] + (weights / (1j * omega[:, None] - poles)).sum(axis=1))
