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
