"""Responses to many inputs against the recursion that they stand for."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.simulation.newton.chunked_responses import CHUNK, responses

RNG = np.random.default_rng(1)


@pytest.mark.parametrize("steps", [1, CHUNK - 1, CHUNK, 3 * CHUNK, 3 * CHUNK + 5])
@pytest.mark.parametrize("rows", [(1,), (2, 0)])
def test_it_is_the_recursion_for_any_number_of_steps(steps: int, rows: tuple[int, ...]) -> None:
    G, B = 0.5 * RNG.standard_normal((3, 3, steps)), RNG.standard_normal((3, 2, steps))
    inputs, start = RNG.standard_normal((2, 4, steps + 3))[:, :, 1 : 1 + steps], RNG.standard_normal((3, 4))
    z, expected = start, np.empty((len(rows), 4, steps))
    for n in range(steps):
        z = G[:, :, n] @ z + B[:, :, n] @ inputs[:, :, n]
        expected[:, :, n] = z[list(rows)]
    out = np.empty((len(rows), 6, steps))
    last = responses(G, B, inputs, rows, out[:, 2:], start)
    assert out[:, 2:] == pytest.approx(expected, rel=1e-12)
    assert last == pytest.approx(z, rel=1e-12)


def test_the_first_state_is_left_as_it_was() -> None:
    start = np.ones((2, 3))
    responses(np.ones((2, 2, 4)), np.ones((2, 1, 4)), np.ones((1, 3, 4)), (0,), np.empty((1, 3, 4)), start)
    assert (start == 1.0).all()
