"""The noise of an angle, by the spectrum of its second differences and by an encoder's quantum."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.signals.angle_noise import acceleration_noise, angle_noise
from robotid.signals.differentiate import differentiate

H = 1e-3
T = np.arange(20_000) * H
MOTION = 20 * np.sin(2 * np.pi * 0.5 * T) + 0.3 * np.sin(2 * np.pi * 9 * T)


@pytest.mark.parametrize("std", [1e-5, 1e-3])
def test_white_noise_is_seen_under_a_motion(std: float) -> None:
    noisy = MOTION + std * np.random.default_rng(1).standard_normal(len(T))
    assert angle_noise(noisy, H) == pytest.approx(2 * std**2 * H, rel=0.2)


def test_a_motion_that_reaches_the_upper_half_of_the_spectrum_is_no_noise() -> None:
    noise = 1e-4 * np.random.default_rng(1).standard_normal(len(T))
    fast = MOTION + 0.02 * np.sin(2 * np.pi * 300 * T)
    assert angle_noise(fast + noise, H) == pytest.approx(2 * 1e-8 * H, rel=0.2)


def test_a_coarse_encoder_has_the_noise_of_its_quantum() -> None:
    quantum = 2 * np.pi / 500
    coarse = quantum * np.round(MOTION / quantum)
    white = quantum**2 / 12 * 2 * H  # and more, slower than a quantum a sample, where it gathers at low frequency
    assert (1.0 - 1e-9) * white < angle_noise(coarse, H) < 10 * white


def test_a_clean_angle_has_none_and_neither_has_a_short_one() -> None:
    assert angle_noise(MOTION, H) < 2 * 1e-12 * H
    assert angle_noise(MOTION[:20], H) == 0.0


def test_differentiation_makes_of_it_at_most_what_an_ideal_filter_would() -> None:
    noise = 1e-4 * np.random.default_rng(2).standard_normal(len(T))
    acceleration = differentiate(noise, H, 40.0).acceleration[1000:-1000]
    assert 1.0 < acceleration_noise(2 * 1e-8 * H, 40.0) / acceleration.var() < 1.5
