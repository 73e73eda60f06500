from __future__ import annotations

import numpy as np
import pytest

from robotid.body.consistent import (
    LeastSquares,
    Start,
    body,
    is_consistent,
    minimise,
    parameters_of,
    pseudo_inertia,
    start_weight,
)

NOTHING = np.zeros(3)


def ball(mass: float, *centre: float) -> np.ndarray:
    return body(mass, np.array(centre), 0.01 * np.eye(3))


def weights(factor: float = 10.0) -> np.ndarray:
    return np.array([start_weight(factor)])


def test_a_pseudo_inertia_goes_to_parameters_and_back() -> None:
    given = np.random.default_rng(1).normal(size=10)
    assert parameters_of(pseudo_inertia(given)) == pytest.approx(given)


def test_a_ball_beside_its_frame_has_the_inertia_of_steiner() -> None:
    mass, x = 3.0, 0.4
    found = ball(mass, x, 0.0, 0.0)
    own = 2 * 0.01 * mass  # of second moments 0.01 in each direction
    assert found == pytest.approx([mass, mass * x, 0, 0, own, 0, 0, own + mass * x**2, 0, own + mass * x**2])


@pytest.mark.parametrize(
    ("change", "possible"),
    [((0, 1.0), True), ((0, -1.1), False), ((1, 5.0), False), ((4, 10.0), False), ((9, -0.5), False)],
)
def test_what_no_mass_can_have_is_found_out(change: tuple[int, float], possible: bool) -> None:
    parameters = ball(1.0, 0.1, 0.2, 0.3)
    parameters[change[0]] += change[1]
    assert is_consistent(parameters) is possible


def least_squares(rows: np.ndarray, torque: np.ndarray) -> LeastSquares:
    return LeastSquares(rows.T @ rows, rows.T @ torque, float(torque @ torque))


def test_data_without_errors_win_over_a_wrong_start() -> None:
    truth = np.concatenate([ball(2.0, 0.3, 0.0, -0.1), [0.7], [-4.0]])
    rows = 1e5 * np.random.default_rng(2).normal(size=(80, 12))
    start = Start(ball(9.0, 0.0, 0.2, 0.0)[None], np.array([2.0]), weights(), weights())
    found = minimise(least_squares(rows, rows @ truth), start)
    assert found.x == pytest.approx(truth, rel=1e-4, abs=1e-5)
    assert found.seen == pytest.approx(1.0, abs=1e-3)


def test_without_data_everything_keeps_its_start() -> None:
    start = Start(ball(9.0, 0.0, 0.2, 0.0)[None], np.array([2.0]), weights(), weights())
    found = minimise(least_squares(np.zeros((5, 11)), np.zeros(5)), start)
    assert found.x == pytest.approx([*start.bodies[0], 2.0], rel=1e-6, abs=1e-8)
    assert found.seen == pytest.approx(0.0, abs=1e-6)


def test_data_that_ask_for_a_negative_mass_get_a_small_one() -> None:
    row = np.eye(10)[:1] * 100.0
    found = minimise(
        least_squares(row, np.array([-300.0])), Start(ball(5.0, 0, 0, 0)[None], np.zeros(0), weights(), np.zeros(0))
    )
    assert is_consistent(found.x)
    assert 0 < found.x[0] < 0.1


def test_the_start_draws_less_the_larger_the_factor() -> None:
    row, start = np.eye(10)[:1], ball(5.0, 0, 0, 0)[None]
    masses = [
        minimise(least_squares(row, np.array([8.0])), Start(start, np.zeros(0), weights(factor), np.zeros(0))).x[0]
        for factor in (1.1, 2.0, 10.0)
    ]
    assert 5.0 < masses[0] < masses[1] < masses[2] < 8.0


def test_a_factor_of_mass_is_one_deviation_of_the_start() -> None:
    """Near the start, the covariance of the logarithm of the mass of a rigid scaling is the factor's logarithm."""
    start = ball(5.0, 0.1, 0, 0)
    scaling = start[None] / (start @ start)  # reads off a scale and nothing else
    flat = minimise(
        least_squares(1e-9 * scaling, np.zeros(1)), Start(start[None], np.zeros(0), weights(1.2), np.zeros(0))
    )
    precision = start @ np.linalg.inv(flat.covariance) @ start
    assert 1 / np.sqrt(precision) == pytest.approx(np.log(1.2), rel=1e-6)
