"""Small dense systems at many samples at once: loops over rows, never over samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array, Mask


def solve(matrices: Array, *columns: Array) -> Array:
    """Solve many small systems by Gauss-Jordan elimination. matrices (d, d, n), columns (d, k, n) each -> all of them
    side by side, (d, sum of k, n).

    Without pivoting: for matrices near the identity, as those of an implicit step or a mass matrix are.
    """
    return eliminate(np.concatenate([matrices, *columns], axis=1))


def eliminate(work: Array) -> Array:
    """Many small systems side by side with their columns, (d, d + k, n), solved in place: the columns (d, k, n).
    Matrices as of `solve`."""
    d = len(work)
    scratch = np.empty_like(work[0])
    for i in range(d):
        pivot = work[i, i + 1 :]
        pivot /= work[i, i]
        for j in range(d):
            if j != i:
                row = work[j, i + 1 :]
                row -= np.multiply(work[j, i], pivot, out=scratch[i + 1 :])
    return work[:, d:]


def inverse(matrices: Array) -> Array:
    """Inverses of many small matrices, (d, d, n) -> (d, d, n)."""
    d, _, n = matrices.shape
    if n == 1:
        return np.asarray(np.linalg.inv(matrices[:, :, 0])[:, :, None])
    return solve(matrices, np.broadcast_to(np.eye(d)[:, :, None], (d, d, n)))


def product(a: Array, b: Array, out: Array | None = None) -> Array:
    """Matrix products at every sample. a (i, j, n or 1), b (j, k, n) or (j, n) -> (i, k, n) or (i, n)."""
    return np.einsum("ijn,j...n->i...n", a, b, out=out)


def with_sticking(mass: Array, sticking: Mask) -> Array:
    """The mass matrix with rows and columns of sticking coordinates those of the identity, (nv, nv, n)."""
    fixed = np.broadcast_to(mass, (*mass.shape[:2], sticking.shape[1])).copy()
    clear_sticking(fixed, sticking)
    clear_sticking(fixed.swapaxes(0, 1), sticking)
    for j, at in enumerate(sticking):
        fixed[j, j, at] = 1.0
    return fixed


def clear_sticking(columns: Array, sticking: Mask) -> None:
    """Set the rows of sticking coordinates (nv, n) to zero in columns (nv, k, n)."""
    for rows, still in zip(columns, sticking, strict=True):
        rows[:, np.flatnonzero(still)] = 0.0


def stacked(values: Sequence[Array | float], x: Array) -> Array:
    """Quantities that may be plain numbers, (k, n)."""
    return np.stack([np.broadcast_to(value, x.shape[1:]) for value in values])
