"""A regression whose errors are alike only within blocks: honest under any colour, and still sharp."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from robotid.diagnosis.scoring.blocked_regression import BlockedRegression, blocked, blocked_beside, together
from robotid.model.array import Array

SAMPLES, BLOCK, H = 6000, 200, 1e-3
DRAWS = 400


def errors(rng: np.random.Generator, pole: float, n: int = SAMPLES) -> Array:
    """A first-order autoregression of unit variance, (n,)."""
    drive = rng.standard_normal(n + 1000) * np.sqrt(1.0 - pole**2)
    return np.asarray(lfilter([1.0], [1.0, -pole], drive)[1000:])


def motions(rng: np.random.Generator, count: int = 3) -> Array:
    """Regressors as an axis has them, smooth or square, (count, n)."""
    t = np.arange(SAMPLES) * H
    waves = [np.sin(2 * np.pi * f * t + p) for f, p in rng.uniform((0.5, 0.0), (4.0, 6.28), (count, 2))]
    return np.stack([np.sign(w) if k % 2 else w for k, w in enumerate(waves)])


def drawn(pole: float, amplitude: float = 0.0, seed: int = 0) -> list[BlockedRegression]:
    rng = np.random.default_rng([seed, round(1000 * pole)])
    found = []
    for _ in range(DRAWS):
        columns = motions(rng)
        found.append(blocked(columns, columns[0] + amplitude * columns[2] + errors(rng, pole), BLOCK))
    return found


@pytest.mark.parametrize("pole", [0.0, 0.9, 0.98])
def test_p_values_of_nothing_are_uniform_whatever_the_colour(pole: float) -> None:
    p = np.array([one.significance([1, 2]) for one in drawn(pole)])
    assert np.mean(p < 0.5) == pytest.approx(0.5, abs=0.1)
    assert np.mean(p < 0.05) < 0.09
    assert np.sum(p < 0.001) <= 4


def test_a_test_that_believes_in_white_noise_is_fooled_by_the_same() -> None:
    """The reason why blocks are needed: here the usual F-test is wrong in most draws."""
    believed = []
    for one in drawn(0.98)[:100]:
        whole = BlockedRegression(
            one.information.sum(axis=0)[None], one.moment.sum(axis=0)[None], one.energy.sum()[None]
        )
        theta = whole.estimate()
        rest = float(whole.energy[0] - theta @ whole.moment[0]) / SAMPLES
        covariance = rest * np.linalg.inv(whole.information[0])
        believed.append(abs(theta[2]) / np.sqrt(covariance[2, 2]) > 3.3)
    assert np.mean(believed) > 0.2


def test_an_effect_above_its_uncertainty_is_found() -> None:
    """An amplitude of 8 standard deviations of white noise."""
    size = 8.0 / np.sqrt(SAMPLES / 2)
    p = np.array([one.significance([2]) for one in drawn(0.0, size)])
    assert np.mean(p < 1e-4) > 0.95


def test_the_covariance_is_that_of_repeated_draws() -> None:
    rng, estimates, told = np.random.default_rng(3), [], []
    columns = motions(rng)
    for _ in range(DRAWS):
        one = blocked(columns, errors(rng, 0.95), BLOCK)
        estimates.append(one.estimate())
        told.append(np.diag(one.covariance()))
    assert np.sqrt(np.mean(told, axis=0)) == pytest.approx(np.std(estimates, axis=0), rel=0.25)


def test_nothing_gains_on_blocks_it_has_not_seen() -> None:
    gains = [one.gain([1, 2]) for one in drawn(0.9)]
    assert np.mean([gain.total > 0.0 for gain in gains]) < 0.2
    assert np.sum([gain.p_value < 0.01 for gain in gains]) <= 4


def test_a_cause_gains_on_blocks_it_has_not_seen() -> None:
    gains = [one.gain([2]) for one in drawn(0.0, 0.2)]
    assert np.mean([gain.total for gain in gains]) == pytest.approx(0.2**2 * SAMPLES / 2, rel=0.35)
    assert np.mean([gain.p_value < 0.01 for gain in gains]) > 0.95


@pytest.mark.parametrize("pole", [0.0, 0.9])
def test_a_constant_amplitude_passes(pole: float) -> None:
    p = np.array([one.constancy(2) for one in drawn(pole, 0.5)])
    assert np.mean(p < 0.05) < 0.09
    assert np.mean(p < 0.01) < 0.025


def test_an_amplitude_that_begins_half_way_does_not_pass() -> None:
    rng, columns = np.random.default_rng(5), motions(np.random.default_rng(5))
    late = 0.5 * columns[2] * (np.arange(SAMPLES) > SAMPLES // 2)
    one = blocked(columns, columns[0] + late + errors(rng, 0.0), BLOCK)
    assert one.constancy(2) < 0.01
    assert one.constancy(0) > 0.01


def test_blocks_of_several_records_are_one_regression() -> None:
    rng = np.random.default_rng(7)
    columns, signal = motions(rng), errors(rng, 0.5)
    halves = [blocked(columns[:, at], signal[at], BLOCK) for at in (slice(0, 3000), slice(3000, SAMPLES))]
    both, whole = together(halves), blocked(columns, signal, BLOCK)
    assert both.count == whole.count == SAMPLES // BLOCK
    assert both.estimate() == pytest.approx(whole.estimate())
    assert both.covariance() == pytest.approx(whole.covariance())


def test_a_regressor_that_is_not_there_does_no_harm() -> None:
    rng, columns = np.random.default_rng(9), motions(np.random.default_rng(9))
    columns[2] = 0.0
    one = blocked(columns, columns[0] + errors(rng, 0.0), BLOCK)
    assert np.isfinite(one.estimate()).all()
    assert one.significance([1]) > 0.001


def test_too_few_blocks_tell_nothing() -> None:
    rng = np.random.default_rng(11)
    one = blocked(motions(rng), errors(rng, 0.0), SAMPLES // 2)
    assert one.count == 2
    assert one.significance([1]) == 1.0


def test_a_regression_on_nothing_keeps_the_energy_of_its_blocks() -> None:
    signal = np.arange(2400.0)
    found = blocked(np.zeros((0, 2400)), signal, 60.0)
    assert found.information.shape == (40, 0, 0)
    assert found.energy.sum() == pytest.approx(float(signal @ signal))


def test_what_lies_along_a_basis_is_taken_out_block_by_block() -> None:
    rng = np.random.default_rng(4)
    basis = np.linalg.qr(rng.standard_normal((1000, 2)))[0]
    signals = rng.standard_normal((5, 1000))
    signals[1] += 1e3 * basis[:, 0]
    signals[2] = 1e3 * basis[:, 1] + 1e-9 * signals[2]  # nothing but rounding is left of it
    left = signals - (signals @ basis) @ basis.T
    left[2] = 0.0
    found, expected = blocked_beside(basis, signals, 130, 1e-6), blocked(left[:-1], left[-1], 130)
    assert found.information == pytest.approx(expected.information, rel=1e-9, abs=1e-9)
    assert found.moment == pytest.approx(expected.moment, rel=1e-9, abs=1e-9)
    assert found.energy == pytest.approx(expected.energy)
    assert not found.information[:, 2].any()
