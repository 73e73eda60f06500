"""The linear system of a trajectory: z[n+1] = G[n] z[n] + columns[n+1], for all samples and right-hand sides at once.

Stacked, it is a unit lower triangular banded matrix, which one LAPACK call (dtbtrs) solves.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dtbtrs

from robotid.model.array import Array


def solve_block_bidiagonal(G: Array, columns: Array, *, adjoint: bool = False) -> Array:
    """Solve z[n+1] = G[n] z[n] + columns[n+1] with z[0] = columns[0].

    G : (nx, nx, n), or (nx, nx, 1) where it is the same everywhere; columns : (nx, q, n + 1) -> z, the same shape.
    adjoint : z[n] = G[n]' z[n+1] + columns[n] instead, from the last sample to the first.
    """
    d, q, nodes = columns.shape
    if q == 0:  # dtbtrs writes beyond a right-hand side that is not there
        return columns.copy()
    band = np.zeros((2 * d, d * nodes))
    for i in range(d):
        for j in range(d):
            band[d + i - j, j : d * (nodes - 1) : d] = -G[i, j]
    rhs = columns.transpose(1, 2, 0).reshape(q, d * nodes).T
    solved, _ = dtbtrs(band, rhs, uplo="L", trans="T" if adjoint else "N", diag="U", overwrite_b=True)
    return np.asarray(solved.T.reshape(q, nodes, d).transpose(2, 0, 1))
