"""Where in an interval a held torque changes."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.signals.resampling import mean_over_intervals
from robotid.signals.torque_steps import TorqueSteps, in_a_row, moved, torque_steps

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


@pytest.mark.parametrize("share", [0.25, 0.3, 0.71])
def test_a_step_goes_into_parts_and_comes_back(share: float) -> None:
    steps, mean = TorqueSteps(np.array([0.5, share]), np.array([0.0, 4.0])), np.array([1.0, -2.0])
    parts = steps.in_parts(mean, 16)
    np.testing.assert_allclose(parts.reshape(2, 16).mean(axis=1), mean)
    found, back = TorqueSteps.of_parts(parts, 16)
    np.testing.assert_allclose(found, mean)
    assert back is not None
    np.testing.assert_allclose(back.share[1], share, atol=0.02)
    np.testing.assert_allclose(back.step, steps.step, rtol=0.02)


def test_a_change_that_is_no_step_keeps_its_first_moment() -> None:
    ramp = (np.arange(16) + 0.5) / 16
    mean, steps = TorqueSteps.of_parts(ramp, 16)
    assert steps is not None
    before, after = (float(level[0]) for level in steps.around(mean))
    share = float(steps.share[0])
    assert share == pytest.approx(0.5)
    assert 0.5 * share**2 * before + 0.5 * (1 - share**2) * after == pytest.approx(1 / 3, rel=1e-2)


def test_parts_that_are_alike_have_no_steps() -> None:
    mean, steps = TorqueSteps.of_parts(np.repeat([0.1, -0.3], 16), 16)
    np.testing.assert_array_equal(mean, [0.1, -0.3])
    assert steps is None


@pytest.mark.parametrize("late", [0.25, -0.25, 1.75, -2.5])
def test_a_held_torque_that_is_moved_has_its_steps_where_they_are_then(late: float) -> None:
    torque = np.array([1.0, 5.0, 2.0, 2.5, -1.0, 0.0])
    mean, steps = moved(torque, None, late)
    at = np.arange(6.0) + late
    assert steps is not None
    held = np.concatenate([torque[:1], torque])[np.searchsorted(at, np.arange(6.0), side="right")]
    np.testing.assert_allclose(steps.around(mean)[0], held, atol=1e-12)
    np.testing.assert_allclose(steps.share[steps.step != 0.0], late % 1.0, atol=1e-12)


def test_a_torque_of_several_steps_an_interval_keeps_its_impulse_when_it_is_moved() -> None:
    rng, parts = np.random.default_rng(1), 1000
    torque, steps = rng.standard_normal(50), TorqueSteps(rng.uniform(0.0, 1.0, 50), rng.standard_normal(50))
    found, _ = moved(torque, steps, 0.3)
    fine = np.concatenate([np.full(300, steps.around(torque)[0][0]), steps.in_parts(torque, parts)])[: 50 * parts]
    np.testing.assert_allclose(found, fine.reshape(-1, parts).mean(axis=1), atol=1e-12)


def test_a_torque_that_is_not_moved_is_as_it_was() -> None:
    rng = np.random.default_rng(1)
    torque, steps = rng.standard_normal(50), TorqueSteps(np.full(50, 0.5), rng.standard_normal(50))
    mean, same = moved(torque, steps, 0.0)
    assert same is not None
    np.testing.assert_allclose(np.stack([mean, same.step]), np.stack([torque, steps.step]), atol=1e-12)


@pytest.mark.parametrize(("width", "center"), [(0.2, 0.5), (0.2, 0.0), (0.06, 0.9)])
def test_the_instants_of_steps_spread_as_wide_as_their_stamps_vary(width: float, center: float) -> None:
    share = (center + width * np.random.default_rng(1).uniform(-0.5, 0.5, 20_000)) % 1.0
    assert TorqueSteps(share, np.ones(20_000)).spread == pytest.approx(width, rel=0.03)


def test_instants_everywhere_spread_over_the_interval_and_none_over_nothing() -> None:
    assert TorqueSteps(np.linspace(0.0, 1.0, 1000, endpoint=False), np.ones(1000)).spread == 1.0
    assert TorqueSteps.none(5).spread == 0.0
