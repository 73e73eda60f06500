"""Signals come from their time stamps onto a regular grid, and lose nothing of what they show."""

from __future__ import annotations

import numpy as np
import pytest
from support.dry_axis import DryAxis, switched_torque

from robotid.model.array import Array
from robotid.signals.differentiate import central_difference
from robotid.signals.resampling import (
    grid_positions,
    interpolate,
    mean_over_intervals,
    resample,
    sampled_regularly,
    speed_error,
)

N = 3000


def jittered(share: float, seed: int = 0) -> Array:
    """Stamps in intervals, off by up to a share of one."""
    return np.sort(np.arange(N) + share * np.random.default_rng(seed).uniform(-1, 1, N))


def rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error[5:-5] ** 2)))


@pytest.mark.parametrize(("h", "share"), [(1e-3, 2e-8), (2e-3, 2e-6), (4e-3, 1e-4)])
def test_a_motion_of_forty_hertz(h: float, share: float) -> None:
    """What is left of an amplitude of one; ignoring the jitter leaves 0.01 to 0.04."""
    at = jittered(0.1)
    grid = grid_positions(at)
    motion = interpolate(at, np.sin(2 * np.pi * 40 * h * at), grid)
    assert rms(motion - np.sin(2 * np.pi * 40 * h * grid)) < share


@pytest.mark.parametrize("h", [1e-3, 2e-3, 4e-3, 1e-2])
def test_an_encoder_shows_no_more_steps_than_on_a_regular_clock(h: float) -> None:
    quantum = 2 * np.pi / 4096

    def read(at: Array) -> Array:
        motion = np.sin(2 * np.pi * min(40.0, 0.2 / h) * h * at) + 5 * np.sin(2 * np.pi * h * at)
        return np.rint(motion / quantum) * quantum

    def true(at: Array) -> Array:
        return np.sin(2 * np.pi * min(40.0, 0.2 / h) * h * at) + 5 * np.sin(2 * np.pi * h * at)

    at = jittered(0.1)
    grid = grid_positions(at)
    regular = rms(central_difference(read(np.arange(N)) - true(np.arange(N)), h))
    assert rms(central_difference(interpolate(at, read(at), grid) - true(grid), h)) < 1.1 * regular


def test_the_mean_torque_keeps_the_impulse() -> None:
    at, torque = jittered(0.4), np.random.default_rng(1).normal(size=N)
    grid = grid_positions(at)
    mean = mean_over_intervals(at, torque, grid)
    fine = np.linspace(grid[10], grid[50], 400_001)
    held = torque[np.searchsorted(at, fine, side="right") - 1]
    assert mean[10:50].sum() == pytest.approx(float(held[:-1].mean()) * 40, abs=2e-3)


def test_a_speed_that_a_held_torque_drives_keeps_its_corners() -> None:
    """Without what the torque drives, the spline would be off by a hundred times as much."""
    at, torque = jittered(0.2), np.random.default_rng(1).normal(size=N)
    speed = np.concatenate([[0.0], np.cumsum(torque[:-1] * np.diff(at))])
    grid = grid_positions(at)
    k = np.searchsorted(at, grid, side="right") - 1
    true = speed[k] + torque[k] * (grid - at[k])
    assert rms(resample(at, {"tau_m": torque, "dphi_m": speed}, ("tau_m",))["dphi_m"] - true) < 1e-6
    assert rms(interpolate(at, speed, grid) - true) > 1e-2


def test_a_torque_that_answers_the_noise_of_the_speed_hides_no_large_step_of_it() -> None:
    """Thousands of small steps have the sign of the noise that they answer, and the only large one comes late."""
    rng, n, gain = np.random.default_rng(3), 3000, 0.08
    late = np.append(0.0, rng.uniform(0.0, 0.2, n - 1))
    at, noise = np.arange(n) + late, 0.02 * rng.standard_normal(n)
    torque = np.where(np.arange(n) < n // 2, 1.0, -12.0) - noise
    speed = gain * np.concatenate([[0.0], np.cumsum(torque[:-1])])
    signals = {"tau_m": torque, "dphi_m": speed + gain * torque * late + noise}
    error = resample(at, signals, ("tau_m",))["dphi_m"] - np.interp(grid_positions(at), np.arange(n), speed)
    assert np.abs(error[n // 2 - 10 : n // 2 + 10]).max() < 0.1
    assert rms(error[100 : n // 2 - 100]) < 0.02


def test_a_speed_keeps_the_corners_of_friction_at_its_reversals() -> None:
    """The torque's corners alone would leave three times as much, and none five times."""
    h, axis = 0.01, DryAxis()
    at = jittered(0.12)[:1000]
    at -= at[0]
    torque = switched_torque(np.arange(1000) * h)
    speed, _ = axis.motion(at * h, torque, at * h)
    grid = grid_positions(at)
    true, _ = axis.motion(at * h, torque, grid * h)
    found = resample(at, {"tau_m": torque, "dphi_m": speed}, ("tau_m",))["dphi_m"]
    assert rms(found - true) < 1e-3
    assert rms(interpolate(at, speed, grid) - true) > 1e-2


def test_what_the_torque_does_not_drive_is_left_alone() -> None:
    at, noise = jittered(0.1), np.random.default_rng(2).normal(size=N)
    unrelated = np.sin(0.05 * at) + 1e-3 * np.random.default_rng(3).normal(size=N)
    found = resample(at, {"tau_m": noise, "dphi_m": unrelated}, ("tau_m",))["dphi_m"]
    np.testing.assert_array_equal(found, interpolate(at, unrelated, grid_positions(at)))


def test_samples_that_nearly_coincide_make_no_slopes() -> None:
    at = np.arange(N, dtype=np.float64)
    at[100] = at[99] + 1e-4
    noisy = np.sin(0.02 * at) + 1e-3 * np.random.default_rng(4).normal(size=N)
    assert rms(interpolate(at, noisy, grid_positions(at)) - np.sin(0.02 * grid_positions(at))) < 2e-3


def test_stamps_that_jitter_are_told_from_sampling_that_jitters() -> None:
    at, numbers = jittered(0.1), np.arange(N, dtype=np.float64)
    assert sampled_regularly(at, numbers, np.sin(0.3 * numbers))
    assert not sampled_regularly(at, numbers, np.sin(0.3 * at))
    assert not sampled_regularly(at, numbers, np.random.default_rng(5).normal(size=N)), "noise cannot tell: the stamps"


def test_bursts_of_stamps_are_told_from_bursts_of_samples() -> None:
    """Within a burst stamps and numbers show the same; what tells them apart is its ends."""
    numbers = np.arange(N, dtype=np.float64)
    at = np.cumsum(np.tile([9.1] + [0.1] * 9, N // 10 + 1))[:N]
    assert sampled_regularly(at, numbers, np.sin(0.3 * numbers))
    assert not sampled_regularly(at, numbers, np.sin(0.02 * at))


def test_what_ignored_jitter_costs() -> None:
    h = 2e-3
    at = jittered(0.1)
    t = np.arange(N) * h
    late, speed = (at - np.arange(N)) * h, 10 * np.sin(2 * np.pi * 5 * t)
    recorded = 10 * np.sin(2 * np.pi * 5 * (t + late)) - speed
    assert speed_error(late, speed, h, derived=False) == pytest.approx(rms(recorded), rel=0.1)
    angle = -10 * np.cos(2 * np.pi * 5 * (t + late)) / (2 * np.pi * 5)
    ignored = central_difference(angle, h) - speed
    assert speed_error(late, speed, h, derived=True) == pytest.approx(rms(ignored), rel=0.1)
