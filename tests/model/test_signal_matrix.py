"""Matrices of signals and plain numbers against the same matrices as arrays."""

from __future__ import annotations

import numpy as np

from robotid.model import signal_matrix
from robotid.model.array import Array
from robotid.model.signal_matrix import Rows

N = 6


def mixed(seed: int) -> Rows:
    """A matrix (3, 3) with signals, numbers, ones, and entries that are not there."""
    rng = np.random.default_rng(seed)
    return [{0: 1.0, 1: rng.standard_normal(N)}, {2: -0.7, 0: rng.standard_normal(N)}, {1: 2.5}]


def dense(rows: Rows, columns: int = 3) -> Array:
    return signal_matrix.put(rows, np.full((len(rows), columns, N), np.nan))


def test_put_writes_zeros_where_nothing_is() -> None:
    found = dense(mixed(0))
    assert np.all(found[0, 2] == 0.0)
    assert np.all(found[2, 1] == 2.5)


def test_multiply_and_add_are_those_of_arrays() -> None:
    a, b = mixed(1), mixed(2)
    expected = np.einsum("ijn,jkn->ikn", dense(a), dense(b))
    product = signal_matrix.multiply(a, b)
    np.testing.assert_allclose(dense(product), expected, rtol=1e-14)
    for factor in (1.0, -1.0, 0.3):
        total = [dict(row) for row in product]
        signal_matrix.add(total, a, factor)
        np.testing.assert_allclose(dense(total), expected + factor * dense(a), rtol=1e-14)
    np.testing.assert_allclose(dense(product), expected, rtol=1e-14)  # what was added to is a copy


def test_at_takes_samples_of_signals_and_leaves_numbers() -> None:
    a = mixed(3)
    a[2][0] = np.array([4.0])
    part = signal_matrix.at(a, slice(2, 5))
    np.testing.assert_array_equal(part[0][1], dense(a)[0, 1, 2:5])
    assert part[0][0] == 1.0
    np.testing.assert_array_equal(part[2][0], [4.0])


def test_constant_matrices_leave_out_zeros() -> None:
    assert signal_matrix.of_numbers(np.array([[0.0, 2.0], [3.0, 0.0]])) == [{1: 2.0}, {0: 3.0}]
