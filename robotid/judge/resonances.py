"""Resonances in the misfit: the frequency at which an effect with a resonance of its own would have to ring.

A grid cannot hold it where there is so little damping that the resonance is narrower than any grid. What the residual
gains from a force at each sample is compared, frequency by frequency, with what the effect makes of the motion; where
it peaks, the effect is scored beside the grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import find_peaks

from robotid.judge.candidates import Candidate
from robotid.judge.columns import with_angle
from robotid.judge.trial import Trial
from robotid.model.array import Array
from robotid.model.lacking_joint import LackingJoint
from robotid.model.port import Port
from robotid.model.term import Motion, Term

PEAKS = 2  # that are tried, the highest
POINTS = 200  # of frequency, over the range of the grid
BEYOND = 2.0  # times the grid's highest frequency: there the effect no longer moves


def resonances(missing: Sequence[Candidate], trial: Trial, gradients: Sequence[Array]) -> tuple[Candidate, ...]:
    """More points for the candidates that ring. gradients (nv, n) : what the residual of each record gains from a
    generalised force."""
    alike = {(c.name, _others(c, k)): (c, k) for c in missing if (k := _ringing(c)) is not None}
    return tuple(new for c, k in alike.values() for new in _at_peaks(c, k, trial, gradients))


def _ringing(candidate: Candidate) -> int | None:
    """The parameter that is the frequency of a resonance."""
    if not isinstance(candidate.effect, Term):
        return None
    return next((k for k, p in enumerate(candidate.effect.parameters) if p.rings), None)


def _others(candidate: Candidate, k: int) -> tuple[float, ...]:
    return (*candidate.values[:k], *candidate.values[k + 1 :])


def _at_peaks(candidate: Candidate, k: int, trial: Trial, gradients: Sequence[Array]) -> Iterator[Candidate]:
    grid, size = candidate.effect.parameters[k].grid, candidate.effect.parameters[candidate.scored[0]]
    points = [_with(candidate, k, float(w)) for w in np.geomspace(min(grid), max(grid), POINTS)]
    gain = np.zeros(POINTS)
    for trajectory, gradient in zip(map(with_angle, trial.motions.fitted), gradients, strict=True):
        assert isinstance(candidate.effect, Term)
        joint = LackingJoint(trajectory.joint, [(Port(str(candidate.place)), candidate.effect)])
        theta, x = np.concatenate([trajectory.theta, candidate.values]), trajectory.x
        v = joint.candidate_motions(x, np.sign(x[joint.speeds]), trajectory.t, theta)[0].v
        absorbed = sum((-c * gradient[j] for j, c in joint.candidates[0].q), np.zeros(x.shape[1]))
        n = 2 * len(v)  # padded: a record is no period
        omega: Array = np.linspace(0.0, np.pi / trajectory.sampling_time, len(v) + 1)
        seen = slice(1, int(np.searchsorted(omega, BEYOND * max(grid))))
        cross = (np.conj(np.fft.rfft(absorbed, n)) * np.fft.rfft(v, n))[seen]
        gain += [float(np.real(_response(one, omega[seen]) @ cross)) for one in points]
    height = gain if size.bounds[0] == size.null else np.abs(gain)
    found, _ = find_peaks(np.maximum(height, 0.0))
    yield from (points[i] for i in sorted(found, key=lambda i: -height[i])[:PEAKS])


def _with(candidate: Candidate, k: int, value: float) -> Candidate:
    return replace(candidate, values=(*candidate.values[:k], value, *candidate.values[k + 1 :]))


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
