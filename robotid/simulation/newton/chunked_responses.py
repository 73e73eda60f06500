"""Responses of a linear time-varying system to many inputs at once, chunk by chunk of samples.

z[n+1] = G[n] z[n] + B[n] f[n]: over a chunk, rows of z are a matrix times the chunk's inputs and its first state. That
matrix is the same for all inputs, so that a product of matrices takes them all through the chunk, where the recursion
takes each of them from sample to sample; it goes on from chunk to chunk only.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.simulation.newton.block_bidiagonal import solve_block_bidiagonal

CHUNK = 16  # samples: a longer one costs more products, a shorter one more steps of the recursion
MANY = 24  # inputs, from which the matrices of the chunks are worth their making


def responses(G: Array, B: Array, inputs: Array, rows: Sequence[int], out: Array, start: Array) -> Array:
    """Write rows of z after every step to out (rows, q, n), and return the last z, (d, q).

    G : (d, d, n); B : (d, b, n); inputs : (b, q, n), of which f[n] are columns; start : (d, q), the first z.
    """
    n, whole = G.shape[2], G.shape[2] - G.shape[2] % CHUNK
    for at, length in ((slice(0, whole), CHUNK), (slice(whole, n), n - whole)):
        if at.stop > at.start:
            start = _through_chunks(G[:, :, at], B[:, :, at], inputs[:, :, at], rows, out[:, :, at], start, length)
    return start


def _through_chunks(
    G: Array, B: Array, inputs: Array, rows: Sequence[int], out: Array, start: Array, length: int
) -> Array:
    """As of `responses`, n a multiple of the chunks' length."""
    d, q, chunks, width = len(G), inputs.shape[1], G.shape[2] // length, len(rows) * length
    through = _chunk_matrices(G, B, rows, length)
    parts = [own.reshape(q, chunks, length).transpose(1, 0, 2) for own in inputs]
    ways = [through[:, d + k : d + k + length] for k in range(0, len(parts) * length, length)]
    local = parts[0] @ ways[0]
    for part, way in zip(parts[1:], ways[1:], strict=True):
        local += part @ way
    between = np.concatenate([start[:, :, None], local[:, :, width:].transpose(2, 1, 0)], axis=2)
    z = solve_block_bidiagonal(through[:, :d, width:].transpose(2, 1, 0), between)
    found = z[:, :, :-1].transpose(2, 1, 0) @ through[:, :d, :width]
    found += local[:, :, :width]
    out.reshape(len(rows), q, chunks, length)[...] = found.reshape(chunks, q, len(rows), length).transpose(2, 1, 0, 3)
    return z[:, :, -1].copy()


def _chunk_matrices(G: Array, B: Array, rows: Sequence[int], length: int) -> Array:
    """What takes every chunk's first state and then its inputs, input by input, to the wanted rows after each of its
    steps, row by row, and then to its last state, (chunks, d + b length, rows length + d)."""
    d, b, chunks = len(G), B.shape[1], G.shape[2] // length
    reached = np.zeros((d, d + b * length, chunks))
    reached[range(d), range(d)] = 1.0
    found = np.empty((chunks, d + b * length, len(rows) * length + d))
    for k in range(length):
        reached = np.einsum("ijc,jmc->imc", G[:, :, k::length], reached)
        reached[:, d + k :: length] = B[:, :, k::length]
        found[:, :, k : len(rows) * length : length] = reached[list(rows)].transpose(2, 1, 0)
    found[:, :, len(rows) * length :] = reached.transpose(2, 1, 0)
    return found
