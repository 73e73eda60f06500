"""What noise does to estimates, where two views of it differ."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.estimate.noise.information import upper_envelope
from robotid.model.array import Array


def random(rank: int, seed: int, size: int = 4) -> Array:
    factor = np.random.default_rng(seed).standard_normal((size, rank))
    return np.asarray(factor @ factor.T)


def test_the_envelope_of_two_matrices_is_below_neither() -> None:
    one, other = random(4, 1), random(4, 2)
    found = upper_envelope(one, other)
    assert found == pytest.approx(upper_envelope(other, one))
    for below in (one, other):
        assert np.linalg.eigvalsh(found - below).min() > -1e-9
    assert np.trace(found) < np.trace(one + other)


def test_the_envelope_of_diagonals_is_their_maximum() -> None:
    found = upper_envelope(np.diag([1.0, 2e-12, 3e12]), np.diag([2.0, 1e-12, 4e12]))
    assert np.abs(found - np.diag(np.diag(found))).max() < 1e-3
    assert np.diag(found) == pytest.approx([2.0, 2e-12, 4e12])


def test_the_envelope_with_nothing_is_the_other() -> None:
    deficient = random(2, 3)
    assert upper_envelope(deficient, np.zeros((4, 4))) == pytest.approx(deficient)
    assert upper_envelope(deficient, deficient) == pytest.approx(deficient)
