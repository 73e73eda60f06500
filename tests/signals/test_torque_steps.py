"""Where in an interval a held torque changes."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.signals.resampling import mean_over_intervals
from robotid.signals.torque_steps import TorqueSteps, in_a_row, torque_steps

GRID = np.arange(4.0)


def test_a_single_step_in_an_interval_is_exact() -> None:
    at, torque = np.array([0.0, 1.3, 2.6, 3.0]), np.array([1.0, 5.0, 2.0, 2.5])
    steps = torque_steps(at, torque, GRID)
    before, after = steps.around(mean_over_intervals(at, torque, GRID))
    np.testing.assert_allclose(steps.share[1:3], [0.3, 0.6])
    np.testing.assert_allclose(before, [1.0, 1.0, 5.0, 2.5])
    np.testing.assert_allclose(after, [1.0, 5.0, 2.0, 2.5])


def test_of_several_steps_impulse_and_first_moment_are_kept() -> None:
    at, torque = np.array([0.0, 1.1, 1.5, 1.8, 3.5]), np.array([1.0, 4.0, -2.0, 1.0, 0.0])
    steps, mean = torque_steps(at, torque, GRID), mean_over_intervals(at, torque, GRID)
    before, after = steps.around(mean)
    share = steps.share[1]
    assert share == pytest.approx(0.5), "the largest step gives the instant"
    fine = 1.0 + (np.arange(100_000) + 0.5) / 100_000
    held = torque[np.searchsorted(at, fine, side="right") - 1]
    assert share * before[1] + (1 - share) * after[1] == pytest.approx(held.mean(), abs=1e-4)
    moment = 0.5 * share**2 * before[1] + 0.5 * (1 - share**2) * after[1]
    assert moment == pytest.approx(np.mean(held * (fine - 1.0)), abs=1e-4)


def test_steps_at_the_samples_are_none() -> None:
    assert not torque_steps(GRID, np.array([1.0, 3.0, -2.0, 4.0]), GRID).step.any()


def test_records_in_a_row() -> None:
    steps = TorqueSteps(np.array([0.2, 0.4]), np.array([1.0, -1.0]))
    assert in_a_row([(None, 3), (None, 2)]) is None
    joined = in_a_row([(None, 1), (steps, 2)])
    assert joined is not None
    np.testing.assert_array_equal(joined.step, [0.0, 1.0, -1.0])
    np.testing.assert_array_equal(joined.take(slice(1, 3)).share, steps.share)
