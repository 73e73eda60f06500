"""Small dense systems at many samples at once: loops over rows, never over samples."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array


def solve(matrices: Array, columns: Array) -> Array:
    """Solve many small systems by Gauss-Jordan elimination. matrices (d, d, n), columns (d, k, n) -> (d, k, n).

    Without pivoting: for matrices near the identity, as those of an implicit step or a mass matrix are.
    """
    d = len(matrices)
    if d == 1:
        return np.asarray(columns / matrices)
    work = np.concatenate([matrices, columns], axis=1)
    for i in range(d):
        pivot = work[i, i + 1 :]
        pivot /= work[i, i]
        for j in range(d):
            if j != i:
                work[j, i + 1 :] -= work[j, i] * pivot
    return work[:, d:]


def inverse(matrices: Array) -> Array:
    """Inverses of many small matrices, (d, d, n) -> (d, d, n)."""
    d, _, n = matrices.shape
    if n == 1:
        return np.asarray(np.linalg.inv(matrices[:, :, 0])[:, :, None])
    return solve(matrices, np.broadcast_to(np.eye(d)[:, :, None], (d, d, n)))


def product(a: Array, b: Array) -> Array:
    """Matrix products at every sample. a (i, j, n), b (j, k, n) -> (i, k, n)."""
    total = a[:, 0, None] * b[None, 0]
    for j in range(1, len(b)):
        total += a[:, j, None] * b[None, j]
    return np.asarray(total)
