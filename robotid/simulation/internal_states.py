"""The memory of an effect that a given motion drives: what its states would be if it were there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.model.array import Array
from robotid.model.linear_algebra import solve
from robotid.model.term import Motion, Partials, Term
from robotid.simulation.newton.block_bidiagonal import solve_block_bidiagonal

MAX_ITERATIONS = 12  # a memory that is smooth settles in four
TOLERANCE = 1e-6  # of the largest state


def simulate_internal_states(term: Term, m: Motion, p: Sequence[float], sampling_time: float) -> Array:
    """States of a term along the motion m of its port over n samples, (k, n), at first settled.

    An implicit one-step rule, fitted to exponentials (Liniger & Willoughby 1970), so that stiff memory follows without
    ringing and slow memory is of order 2; all samples at once by Newton's method.
    """
    n = len(m.v)
    z = np.stack([np.broadcast_to(np.asarray(value, dtype=np.float64), (n,)) for value in term.settled(m, p)])
    for _ in range(MAX_ITERATIONS):
        here = replace(m, z=z)
        rate = sampling_time * np.stack([np.broadcast_to(r, (n,)) for r in term.rate(here, p)])
        slope = sampling_time * _slopes(term.rate_partials(here, p), n)
        late = _weight(np.stack([slope[i, i] for i in range(len(z))]))
        defect = z[:, :-1] - z[:, 1:] + (1.0 - late) * rate[:, :-1] + late * rate[:, 1:]
        if np.abs(defect).max() <= TOLERANCE * np.abs(z).max():
            break
        z = z + _newton_step(defect, slope, late)
    return z


def _slopes(partials: Sequence[Partials], n: int) -> Array:
    """d(rate)/dz, (k, k, n)."""
    return np.stack([np.stack([np.broadcast_to(value, (n,)) for value in d.z]) for d in partials])


def _weight(stiffness: Array) -> Array:
    """Weight of the interval's end that makes the rule exact for dz/dt = -q z: 1/2 for slow, 1 for stiff memory."""
    q = np.maximum(-stiffness[:, 1:], 1e-4)
    return np.asarray(1.0 / -np.expm1(-q) - 1.0 / q)


def _newton_step(defect: Array, slope: Array, late: Array) -> Array:
    """Change of the states, (k, n), that solves the linearised rule; those at the first sample stay."""
    eye = np.eye(len(defect))[:, :, None]
    right, left = eye - late[:, None] * slope[:, :, 1:], eye + (1.0 - late)[:, None] * slope[:, :, :-1]
    solved = solve(right, left, defect[:, None])
    columns = np.zeros((len(defect), 1, defect.shape[1] + 1))
    columns[:, 0, 1:] = solved[:, -1]
    return np.asarray(solve_block_bidiagonal(solved[:, :-1], columns)[:, 0])
