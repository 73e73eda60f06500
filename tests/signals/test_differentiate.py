"""Zero-phase filtering and differentiation."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.signals.differentiate import (
    ParallelFilter,
    bandwidth,
    central_difference,
    decimate,
    differentiate,
    low_pass,
    transform_length,
)

H = 1e-3
T = np.arange(10_000) * H
INNER = slice(1000, -1000)


def test_derivatives_of_a_sine() -> None:
    omega = 2 * np.pi * 2.0
    motion = differentiate(0.3 * np.sin(omega * T), H, cutoff=50.0)
    assert motion.position[INNER] == pytest.approx(0.3 * np.sin(omega * T)[INNER], abs=1e-6)
    assert motion.speed[INNER] == pytest.approx(0.3 * omega * np.cos(omega * T)[INNER], abs=1e-3)
    assert motion.acceleration[INNER] == pytest.approx(-0.3 * omega**2 * np.sin(omega * T)[INNER], abs=1e-2)


def test_derivative_of_a_parabola_is_exact_up_to_the_ends() -> None:
    assert central_difference(T**2, H) == pytest.approx(2 * T, abs=1e-9)


def test_gain_at_the_cutoff_is_one_half_and_there_is_no_phase() -> None:
    sine, cosine = np.sin(2 * np.pi * 20 * T), np.cos(2 * np.pi * 20 * T)
    filtered = low_pass(sine, H, cutoff=20.0)[INNER]
    in_phase, quadrature = (2 * np.mean(filtered * s[INNER]) for s in (sine, cosine))
    assert in_phase == pytest.approx(0.5, abs=1e-3)
    assert quadrature == pytest.approx(0.0, abs=1e-3)


def test_noise_beyond_the_cutoff_goes() -> None:
    noise = np.random.default_rng(1).standard_normal(len(T))
    assert low_pass(noise, H, cutoff=5.0)[INNER].std() < 0.12


def test_a_cutoff_beyond_the_nyquist_frequency_filters_nothing() -> None:
    noise = np.random.default_rng(2).standard_normal(len(T))
    assert np.array_equal(low_pass(noise, H, cutoff=450.0), noise)


def test_rows_are_filtered_alike() -> None:
    noise = np.random.default_rng(3).standard_normal((2, 3, len(T)))
    assert low_pass(noise, H, 30.0)[1, 2] == pytest.approx(low_pass(noise[1, 2], H, 30.0))


def test_decimation_keeps_the_relation_between_signals() -> None:
    noise = np.random.default_rng(4).standard_normal(len(T))
    both = decimate(np.array([noise, 3.0 * noise]), H, cutoff=10.0)
    assert both[1] == pytest.approx(3.0 * both[0])
    assert both.shape == (2, len(range(100, len(T) - 100, 25)))


def test_decimation_leaves_most_of_a_short_signal() -> None:
    assert decimate(np.ones(80), H, cutoff=1.0).shape[-1] == 1
    assert decimate(np.ones(80), H, cutoff=40.0).shape[-1] == 10


def test_bandwidth_of_a_sine_in_noise() -> None:
    noise = 0.1 * np.random.default_rng(5).standard_normal(len(T))
    assert bandwidth(5.0 + np.sin(2 * np.pi * 12 * T) + noise, H) == pytest.approx(12.0, abs=0.3)


def test_bandwidth_of_a_constant() -> None:
    assert bandwidth(np.full(1000, 3.0), H) == 0.0


def test_a_spectrum_of_a_long_signal_leaves_out_its_last_samples() -> None:
    assert transform_length(999_983) == 999_983  # a prime
    kept = transform_length(1_000_003)  # another
    assert kept % 4_096 == 0
    assert 1_000_003 - kept < 4_096
    signal = np.sin(2 * np.pi * 5.0 * np.arange(1_000_003) * 1e-3)
    assert bandwidth(signal, 1e-3) == bandwidth(signal[:kept], 1e-3)


def test_a_sample_shows_within_half_a_period_of_the_cutoff_in_what_is_left_of_all() -> None:
    parallel, samples = ParallelFilter(20.0), np.arange(len(T)) == 5000
    reached = parallel.reached_by(samples, H)
    at = parallel.apply(T, H)[reached]
    assert len(reached) == len(parallel.apply(T, H))
    assert at.min() == pytest.approx(5.0 - 0.025, abs=0.0125)
    assert at.max() == pytest.approx(5.0 + 0.025, abs=0.0125)
