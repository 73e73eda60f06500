"""Frequency responses of systems whose response is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import cont2discrete, dlsim

from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.signals.frf import Complex, Frf, combine, estimate_frf
from robotid.signals.record import Record

H, PERIOD, BAND = 1e-3, 4.0, (1.0, 40.0)
N = round(PERIOD / H)
JM, JA, K, D = 0.01, 0.02, 20.0, 0.05  # two masses without gear: notch 31.6 rad/s, resonance 54.8 rad/s


def truth(frequency: Array) -> Complex:
    """Torque to acceleration of the two masses."""
    s = 2j * np.pi * frequency
    spring = (D * s + K) / s**2
    return np.asarray(1 / (JM + 1 / (1 / JA + 1 / spring)))


def multisine(seed: int, periods: int = 1) -> Array:
    lines = np.arange(round(BAND[0] * PERIOD), round(BAND[1] * PERIOD) + 1)
    spectrum = np.zeros(N // 2 + 1, dtype=complex)
    spectrum[lines] = np.exp(2j * np.pi * np.random.default_rng(seed).random(len(lines)))
    u = np.fft.irfft(spectrum, N)
    return np.tile(u / u.std(), periods)


def respond(u: Array) -> tuple[Array, Array]:
    """Motor angle and speed of the two masses under a held torque, from rest."""
    A = np.array([[0, 1, 0, 0], [-K / JM, -D / JM, K / JM, D / JM], [0, 0, 0, 1], [K / JA, D / JA, -K / JA, -D / JA]])
    B = np.array([[0], [1 / JM], [0], [0]])
    model = cont2discrete((A, B, np.eye(2, 4), np.zeros((2, 1))), H)
    y = dlsim(model, u)[1]
    return y[:, 0], y[:, 1]


def record(
    u: Array, noise: float = 0.0, seed: int = 0, ref: Array | None = None, period: float | None = PERIOD
) -> Record:
    """Open loop: the torque is its own reference, given as the speed that a pure inertia would have."""
    phi, v = respond(u)
    v = v + noise * np.random.default_rng(seed).standard_normal(len(v))
    ref = np.cumsum(u) * H if ref is None else ref
    return Record("r", "estimate", "flex", H, u, phi, v, ref=ref, ref_kind="speed", period=period, band=BAND)


def distance(frf: Frf) -> Array:
    """Error in its own standard deviations, (n,)."""
    return np.asarray(np.abs(frf.response - truth(frf.frequency)) / frf.std)


def relative(frf: Frf) -> Array:
    return np.asarray(np.abs(frf.response / truth(frf.frequency) - 1))


def test_one_period_from_rest_transient_and_all() -> None:
    frf = estimate_frf(record(multisine(1)))
    assert frf.frequency[[0, -1]] == pytest.approx(BAND)
    assert np.median(relative(frf)) < 0.01
    assert frf.omega[np.argmin(np.abs(frf.response))] == pytest.approx(np.sqrt(K / JA), rel=0.03)


def test_errors_of_one_period_are_as_large_as_their_standard_deviation() -> None:
    frf = estimate_frf(record(multisine(2), noise=0.05, seed=2))
    assert 0.4 < np.median(distance(frf)) < 1.6
    assert np.quantile(distance(frf), 0.95) < 6


def test_periods_are_averaged_and_tell_the_noise() -> None:
    frf = estimate_frf(record(multisine(3, periods=9), noise=0.05, seed=3))
    assert frf.noise_std is not None
    assert np.median(relative(frf)) < 0.01
    assert 0.5 < np.sqrt(np.mean(distance(frf)[4:] ** 2)) < 1.5
    assert "8 periods" in frf.remarks[0]


def test_the_hold_is_taken_out() -> None:
    frf = estimate_frf(record(multisine(4, periods=12)))
    top = frf.frequency > 30
    assert np.angle(frf.response / truth(frf.frequency))[top] == pytest.approx(0.0, abs=2e-3)  # half a sample is 0.1


def closed_loop(ref: Array, noise: float, period: float | None) -> Record:
    """An inertia of 0.01 kg m2 under a speed controller that feeds back much noise."""
    rng = np.random.default_rng(5)
    u, v, true_v = np.empty(len(ref)), np.empty(len(ref)), 0.0
    for n in range(len(ref)):
        v[n] = true_v + noise * rng.standard_normal()
        u[n] = 0.05 * (ref[n] - v[n])
        true_v += H / 0.01 * u[n]
    return Record(
        "loop", "estimate", "flex", H, u, 0 * u, v, ref=ref, ref_kind="speed", period=period, band=(10.0, 40.0)
    )


def test_the_reference_as_instrument_is_not_biased_in_closed_loop() -> None:
    noisy = closed_loop(np.random.default_rng(6).standard_normal(50 * N), noise=0.15, period=None)
    safe, biased = estimate_frf(noisy), estimate_frf(replace(noisy, ref=None, ref_kind=None))
    assert abs(np.average(safe.response, weights=safe.std**-2) / 100 - 1) < 0.1
    assert abs(np.average(biased.response, weights=biased.std**-2) / 100 - 1) > 0.3
    assert any("biased" in remark for remark in biased.remarks)
    assert not any("biased" in remark for remark in safe.remarks)


def test_the_mean_over_periods_needs_no_reference() -> None:
    noisy = closed_loop(multisine(5, periods=25), noise=0.3, period=PERIOD)
    frf = estimate_frf(replace(noisy, ref=None, ref_kind=None))
    assert np.mean(frf.response.real) == pytest.approx(100, rel=0.1)
    assert not any("biased" in remark for remark in frf.remarks)


def test_a_record_that_does_not_repeat() -> None:
    u = np.random.default_rng(6).standard_normal(6 * N)
    frf = estimate_frf(replace(record(u, period=None), band=None), band=(1.0, 40.0))
    assert np.median(relative(frf)) < 0.02
    assert len(frf.frequency) <= 400


def test_a_band_is_found_where_none_is_given() -> None:
    frf = estimate_frf(replace(record(multisine(7), period=None), band=None))
    assert 0.4 < frf.frequency[0] < 1.5
    assert 35 < frf.frequency[-1] < 45


def test_sparse_lines_widen_the_neighbourhood() -> None:
    lines = np.zeros(N // 2 + 1, dtype=complex)
    odd = np.arange(5, 160, 2)
    lines[odd] = np.exp(2j * np.pi * np.random.default_rng(8).random(len(odd)))
    frf = estimate_frf(record(np.fft.irfft(lines, N) * N / 10))
    assert frf.frequency == pytest.approx(odd / PERIOD)
    assert np.median(relative(frf)) < 0.05


def test_speed_response() -> None:
    frf = estimate_frf(record(multisine(9)))
    assert frf.speed_response * 1j * frf.omega == pytest.approx(frf.response)


def test_realisations_tell_distortion_from_noise() -> None:
    def frfs(cubic: float) -> tuple[Frf, ...]:
        made = [record(multisine(20 + k, periods=5), noise=0.002, seed=k) for k in range(6)]
        return tuple(estimate_frf(replace(r, tau_m=r.tau_m + cubic * r.dphi_m**3)) for r in made)

    linear, bent = combine("linear", frfs(0.0)), combine("bent", frfs(2e-4))
    assert linear.distortion_std is not None
    assert bent.distortion_std is not None
    assert bent.noise_std is not None
    assert np.median(bent.distortion_std) > 10 * np.median(linear.distortion_std)
    assert np.median(bent.distortion_std) > 10 * np.median(bent.noise_std)


def test_a_band_without_lines_is_refused() -> None:
    with pytest.raises(NumericsError, match=r"0 excited lines between 0\.01 and 0\.02 Hz"):
        estimate_frf(record(multisine(10)), band=(0.01, 0.02))
