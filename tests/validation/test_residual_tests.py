"""The residual tests on noise of known making."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from robotid.model.array import Array
from robotid.validation.residual_tests import LAGS, quantile, residual_test

N, DRAWS = 1500, 400


def coloured(rng: np.random.Generator, pole: float) -> Array:
    return np.asarray(lfilter([1.0], [1.0, -pole], rng.standard_normal(N)))


def alarms(pole: float) -> tuple[int, int]:
    """How many of the draws of residual and independent torque are called coloured, and dependent."""
    rng = np.random.default_rng(3)
    tests = [residual_test(coloured(rng, pole), coloured(rng, 0.95)) for _ in range(DRAWS)]
    return sum(not t.white for t in tests), sum(not t.independent for t in tests)


def test_white_noise_is_called_coloured_in_one_of_a_hundred():
    whiteness, independence = alarms(0.0)
    assert 0 < whiteness <= 0.03 * DRAWS
    assert independence <= 0.03 * DRAWS


def test_correlations_are_those_of_all_pairs_of_samples():
    rng = np.random.default_rng(3)
    e, u = rng.standard_normal((2, 301))
    found, (e, u) = residual_test(e, u), (e - e.mean(), u - u.mean())
    auto, cross = np.correlate(e, e, "full")[300:], np.correlate(e, u, "full")[300 - LAGS : 301 + LAGS]
    np.testing.assert_allclose(found.autocorrelation, auto[1 : LAGS + 1] / auto[0], atol=1e-12)
    np.testing.assert_allclose(found.crosscorrelation, cross / np.sqrt((e @ e) * (u @ u)), atol=1e-12)


def test_coloured_noise_is_found_and_is_not_laid_to_the_torque():
    whiteness, independence = alarms(0.8)
    assert whiteness == DRAWS
    assert independence <= 0.03 * DRAWS


def test_a_residual_that_follows_the_torque_late():
    rng = np.random.default_rng(4)
    torque = coloured(rng, 0.5)
    residual = rng.standard_normal(N) + 0.3 * np.roll(torque, 7)
    test = residual_test(residual, torque)
    assert not test.independent
    assert test.verdict == "follows the torque: the model lacks something"
    half = len(test.crosscorrelation) // 2
    assert np.argmax(np.abs(test.crosscorrelation)) - half == 7


def test_feedback_is_shown_but_not_held_against_the_model():
    rng = np.random.default_rng(5)
    residual = rng.standard_normal(N)
    torque = coloured(rng, 0.5) - 2 * np.roll(residual, 3)  # the controller answers three samples later
    test = residual_test(residual, torque)
    half = len(test.crosscorrelation) // 2
    assert test.independent
    assert np.argmax(np.abs(test.crosscorrelation)) - half == -3
    assert abs(test.crosscorrelation[half - 3]) > 5 * test.cross_band


def test_all_correlations_keep_to_their_band_in_99_of_100_records():
    rng = np.random.default_rng(6)
    tests = [residual_test(rng.standard_normal(N), coloured(rng, 0.5)) for _ in range(DRAWS)]
    within = [np.all(np.abs(t.autocorrelation) <= t.band) for t in tests]
    apart = [np.all(np.abs(t.crosscorrelation[LAGS + 1 :]) <= t.cross_band) for t in tests]
    assert [np.mean(within), np.mean(apart)] == pytest.approx([0.99, 0.99], abs=0.012)
    assert tests[0].band == pytest.approx(quantile(LAGS) / np.sqrt(N))
    assert tests[0].cross_band == pytest.approx(tests[0].band, rel=0.15)


@pytest.mark.parametrize("share", [0.0, 0.03, 0.06, 0.1, 0.3])
def test_a_verdict_is_what_the_bars_beside_the_band_show(share):
    rng = np.random.default_rng(9)
    for _ in range(40):
        torque = coloured(rng, 0.95)
        test = residual_test(coloured(rng, share) + share * np.roll(torque, 4), torque)
        assert test.white == bool(np.all(np.abs(test.autocorrelation) <= test.band))
        assert test.independent == bool(np.all(np.abs(test.crosscorrelation[LAGS + 1 :]) <= test.cross_band))


def test_white_noise_beneath_a_slow_misfit():
    rng = np.random.default_rng(7)
    slow = 0.3 * np.sin(2 * np.pi * np.arange(N) / 500)
    test = residual_test(0.1 * rng.standard_normal(N) + slow, coloured(rng, 0.9))
    assert test.white_part == pytest.approx(0.1, rel=0.1)
    assert test.coloured_part == pytest.approx(0.3 / np.sqrt(2), rel=0.05)


def test_a_perfect_residual_has_nothing_to_test():
    test = residual_test(np.zeros(N), coloured(np.random.default_rng(8), 0.5))
    assert test.white
    assert test.independent
    assert test.white_part == test.coloured_part == 0.0
