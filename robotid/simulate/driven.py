"""The memory of an effect that a given motion drives: what its states would be if it were there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_banded

from robotid.model.array import Array
from robotid.model.term import Motion, Partials, Term

MOST_ITERATIONS = 12
TOLERANCE = 1e-6


def driven(term: Term, m: Motion, p: Sequence[float], sampling_time: float) -> Array:
    """States of a term along the motion m of its port over n samples, (k, n), at first settled.

    An implicit one-step rule, fitted to exponentials (Liniger & Willoughby 1970), so that stiff memory follows without
    ringing and slow memory is of order 2; all samples at once by Newton's method.
    """
    n = len(m.v)
    z = np.stack([np.broadcast_to(np.asarray(value, dtype=np.float64), (n,)) for value in term.settled(m, p)])
    for _ in range(MOST_ITERATIONS):
        here = replace(m, z=z)
        rate = np.stack([np.broadcast_to(r, (n,)) for r in term.rate(here, p)])
        slope = _slopes(term.rate_partials(here, p), n)
        late = _weight(sampling_time * np.stack([slope[i, i] for i in range(len(z))]))
        change = _newton_step(z, rate, slope, late, sampling_time)
        z = z + change
        if np.abs(change).max() <= TOLERANCE * max(float(np.abs(z).max()), 1e-300):
            break
    return z


def _slopes(partials: Sequence[Partials], n: int) -> Array:
    """d(rate)/dz, (k, k, n)."""
    return np.stack([np.stack([np.broadcast_to(value, (n,)) for value in d.z]) for d in partials])


def _weight(stiffness: Array) -> Array:
    """Weight of the interval's end that makes the rule exact for dz/dt = -q z: 1/2 for slow, 1 for stiff memory."""
    q = np.maximum(-stiffness[:, 1:], 1e-4)
    return np.asarray(1.0 / -np.expm1(-q) - 1.0 / q)


def _newton_step(z: Array, rate: Array, slope: Array, late: Array, h: float) -> Array:
    """Change of z (k, n) that solves the linearised rule; the first sample stays."""
    k, n = z.shape
    defect = np.zeros_like(z)
    defect[:, 1:] = z[:, :-1] - z[:, 1:] + h * ((1.0 - late) * rate[:, :-1] + late * rate[:, 1:])
    band = np.zeros((3 * k - 1, k * n))
    for i in range(k):
        for j in range(k):
            band[k - 1 + i - j, j] = float(i == j)
            band[k - 1 + i - j, k + j :: k] = float(i == j) - h * late[i] * slope[i, j, 1:]
            band[2 * k - 1 + i - j, j : k * (n - 1) : k] = -float(i == j) - h * (1.0 - late[i]) * slope[i, j, :-1]
    solved = solve_banded((2 * k - 1, k - 1), band, defect.T.reshape(-1), overwrite_ab=True, check_finite=False)
    return np.asarray(solved.reshape(n, k).T)
