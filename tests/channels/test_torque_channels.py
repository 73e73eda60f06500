"""Delay and lag of a held torque against their definitions on a fine grid."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.channels import CHANNELS
from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.companion import Course
from robotid.model.port import Signal

H = 1e-3
FINE = 1000

DELAY, LAG = CHANNELS["torque_delay"], CHANNELS["torque_lag"]


def torque(n: int = 30) -> Array:
    return np.asarray(np.random.default_rng(3).normal(size=n))


def test_gain_and_saturation_are_those_of_their_equations() -> None:
    u = torque()
    np.testing.assert_allclose(CHANNELS["torque_gain"].apply(u, H, [0.1]), 1.1 * u, rtol=1e-14)
    np.testing.assert_allclose(CHANNELS["torque_saturation"].apply(u, H, [0.25]), 2.0 * np.tanh(u / 2.0), rtol=1e-14)


@pytest.mark.parametrize("samples", [0.0, 0.25, 1.0, 2.618, 7.5, 29.0, 40.3])
def test_delay_is_the_mean_of_the_shifted_hold(samples: float) -> None:
    u = torque()
    fine = np.repeat(u, FINE)
    shift = round(samples * FINE)
    shifted = np.concatenate([np.full(shift, u[0]), fine])[: fine.size]
    mean = shifted.reshape(-1, FINE).mean(axis=1)
    np.testing.assert_allclose(DELAY.apply(u, H, [samples * H]), mean, atol=1e-12)


@pytest.mark.parametrize("T", [2e-5, 3e-4, 1e-3, 2e-2, 5.0])
def test_lag_is_the_mean_of_the_filtered_hold(T: float) -> None:
    u = torque()
    nodes, weights = np.polynomial.legendre.leggauss(60)
    within, y, mean = (nodes + 1) / 2 * H, u[0], []
    for level in u:  # the step response of each interval, one after the other
        mean.append(weights @ (level + (y - level) * np.exp(-within / T)) / 2)
        y = level + (y - level) * np.exp(-H / T)
    np.testing.assert_allclose(LAG.apply(u, H, [T]), mean, atol=1e-12)


@pytest.mark.parametrize("channel", [DELAY, LAG], ids=["delay", "lag"])
def test_first_order_loss_at_zero_is_one_backward_difference(channel: Channel) -> None:
    u = torque()
    loss = -np.diff(u, prepend=u[0]) / H
    partial = channel.partials(u, H, [0.0])
    np.testing.assert_allclose(partial, loss[None], rtol=1e-14)


@pytest.mark.parametrize("T", [1e-320, 1e-12, H / 700, H / 699])
def test_lag_is_smooth_down_to_nothing(T: float) -> None:
    u = torque()
    loss = -np.diff(u, prepend=u[0]) / H
    np.testing.assert_allclose(LAG.apply(u, H, [T]), u + T * loss, rtol=1e-12)
    np.testing.assert_allclose(LAG.partials(u, H, [T]), loss[None], rtol=1e-12)


@pytest.mark.parametrize("channel", [DELAY, LAG], ids=["delay", "lag"])
@pytest.mark.parametrize("time", [0.0, 3e-4, 0.4])
def test_a_constant_torque_passes(channel: Channel, time: float) -> None:
    steady = np.full(50, 2.5)
    np.testing.assert_array_equal(channel.apply(steady, H, [time]), steady)
    assert not np.any(channel.partials(steady, H, [time]))


@pytest.mark.parametrize("name", [name for name, one in CHANNELS.items() if Signal.TORQUE in one.signals])
def test_a_channel_says_whether_a_held_torque_changes_within_intervals(name: str) -> None:
    channel = CHANNELS[name]
    course = Course(np.vstack([48.0 + torque(), np.zeros((2, 30))]), H)
    one = channel.reading("w").beside({"w": course}) if channel.companion else channel
    values = [p.guess for p in channel.parameters]
    after = one.on_parts(4).apply(np.repeat(torque(), 4), H / 4, values).reshape(-1, 4)
    assert bool(np.ptp(after, axis=1).any()) == channel.has_memory
    np.testing.assert_allclose(after.mean(axis=1), one.apply(torque(), H, values), atol=1e-12)


def test_a_filter_through_which_a_torque_was_recorded_is_undone() -> None:
    u, T = torque(), 0.7 * H
    smoothed = np.empty_like(u)
    smoothed[0] = u[0]
    for k in range(1, len(u)):
        smoothed[k] = smoothed[k - 1] + H / (T + H) * (u[k] - smoothed[k - 1])
    np.testing.assert_allclose(CHANNELS["torque_filter"].apply(smoothed, H, [T]), u, atol=1e-13)
