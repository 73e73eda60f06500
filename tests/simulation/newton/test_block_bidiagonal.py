"""The banded solve against the recursion that it stands for."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.simulation.newton.block_bidiagonal import solve_block_bidiagonal

RNG = np.random.default_rng(1)
G, COLUMNS = 0.5 * RNG.standard_normal((3, 3, 7)), RNG.standard_normal((3, 2, 8))


def test_forward_it_is_the_recursion_from_the_first_sample() -> None:
    z = solve_block_bidiagonal(G, COLUMNS)
    expected = [COLUMNS[:, :, 0]]
    for n in range(7):
        expected.append(G[:, :, n] @ expected[-1] + COLUMNS[:, :, n + 1])
    assert z == pytest.approx(np.stack(expected, axis=-1), rel=1e-12)


def test_the_adjoint_is_the_recursion_from_the_last_sample() -> None:
    z = solve_block_bidiagonal(G, COLUMNS, adjoint=True)
    expected = [COLUMNS[:, :, -1]]
    for n in reversed(range(7)):
        expected.insert(0, G[:, :, n].T @ expected[0] + COLUMNS[:, :, n])
    assert z == pytest.approx(np.stack(expected, axis=-1), rel=1e-12)


def test_one_matrix_may_stand_for_all_samples() -> None:
    same = np.repeat(G[:, :, :1], 7, axis=2)
    assert np.array_equal(solve_block_bidiagonal(G[:, :, :1], COLUMNS), solve_block_bidiagonal(same, COLUMNS))


def test_the_right_hand_sides_stay_as_they_are() -> None:
    before = COLUMNS.copy()
    solve_block_bidiagonal(G, COLUMNS)
    assert np.array_equal(COLUMNS, before)


@pytest.mark.parametrize("adjoint", [False, True])
def test_without_a_right_hand_side_nothing_is_solved(adjoint: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """LAPACK's solver writes beyond its memory there, which shows much later."""
    monkeypatch.delattr("robotid.simulation.newton.block_bidiagonal.dtbtrs")
    found = solve_block_bidiagonal(np.full((3, 3, 100), 0.1), np.zeros((3, 0, 101)), adjoint=adjoint)
    assert found.shape == (3, 0, 101)
