"""Covariances of a fit, some of whose unknowns do not show."""

from __future__ import annotations

import numpy as np

from robotid.estimate import uncertainty

SAMPLES, PIECES, PARAMETERS = 17, 17, 6


def test_first_states_that_show_nowhere_leave_the_parameters_as_they_are() -> None:
    """Two a piece, every fourth piece at rest: where the motor rests its simulation does, wherever it began."""
    rng = np.random.default_rng(0)
    jacobian = np.zeros((PARAMETERS + 2 * PIECES, SAMPLES * PIECES))
    jacobian[:PARAMETERS] = rng.standard_normal((PARAMETERS, SAMPLES * PIECES))
    for k in range(PIECES):
        first = PARAMETERS + 2 * k
        if k % 4:
            jacobian[first : first + 2, SAMPLES * k : SAMPLES * (k + 1)] = rng.standard_normal((2, SAMPLES))
    found, unseen = uncertainty._inverse(jacobian @ jacobian.T)
    shown = np.flatnonzero(jacobian.any(axis=1))
    np.testing.assert_allclose(
        found[np.ix_(shown, shown)], np.linalg.inv(jacobian[shown] @ jacobian[shown].T), atol=1e-9
    )
    assert not found[:, np.setdiff1d(np.arange(len(found)), shown)].any()
    assert unseen.shape[1] == len(found) - len(shown)


def test_a_size_in_its_shape_is_that_of_least_squares_with_the_shape_held() -> None:
    """Of white errors, and of errors as large as their sample has them, whose estimate is not the best one."""
    rng = np.random.default_rng(1)
    columns, error = rng.standard_normal((4, 300)), np.linspace(0.1, 3.0, 300)
    columns[3] += 5.0 * columns[1]
    plain = np.linalg.inv(columns @ columns.T)
    robust = plain @ (columns * error**2) @ columns.T @ plain
    held = np.linalg.inv(columns[:3] @ columns[:3].T)
    both = held @ (columns[:3] * error**2) @ columns[:3].T @ held
    np.testing.assert_allclose(uncertainty.in_their_shape(plain, plain, [1], [3]), held[1:2, 1:2])
    np.testing.assert_allclose(uncertainty.in_their_shape(plain, robust, [1], [3]), both[1:2, 1:2])
    assert held[1, 1] < 0.1 * plain[1, 1]


def test_a_shape_that_was_not_fitted_is_none() -> None:
    covariance = np.diag([1.0, 4.0, 0.0])
    assert uncertainty.in_their_shape(covariance, covariance, [1], []) == 4.0
    assert uncertainty.in_their_shape(covariance, covariance, [1], [2]) == 4.0
