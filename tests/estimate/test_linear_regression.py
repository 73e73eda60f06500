"""Linear least squares within limits."""

from __future__ import annotations

import numpy as np

from robotid.estimate.linear_regression import Block, Limits, solve, solve_within


def test_what_stops_at_a_limit_is_exactly_there_and_the_others_are_least_squares() -> None:
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((3, 400))
    tau = np.array([0.5, -0.3, 2.0]) @ columns + 0.01 * rng.standard_normal(400)
    blocks = [Block(columns, tau)]
    free = solve(["a", "b", "c"], blocks)
    limits = Limits(np.array([-1.0, 0.0, -np.inf]), np.array([1.0, np.inf, 1.5]))
    theta = solve_within(blocks, free, limits)
    assert theta[1] == 0.0
    assert theta[2] == 1.5
    left = tau - 1.5 * columns[2]
    assert np.isclose(theta[0], columns[0] @ left / (columns[0] @ columns[0]))
    wide = Limits(np.full(3, -9.0), np.full(3, 9.0))
    assert solve_within(blocks, free, wide) is free.theta
