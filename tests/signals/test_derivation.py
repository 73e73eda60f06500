"""Speeds that come from an angle: what is left of the angle in them, and the adjoints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.signals.derivation import Derivation, without
from robotid.signals.record import OPERATORS, Record, SpeedOrigin

H = 0.004
ORIGINS: list[SpeedOrigin] = list(OPERATORS)


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("n", [20, 21])
def test_the_angle_comes_back_but_for_what_is_lost(origin: SpeedOrigin, n: int) -> None:
    derivation, angle = Derivation(origin, H), np.random.default_rng(1).standard_normal((2, n))
    lost = derivation.lost(n)
    assert np.abs(derivation.speed(lost)[:, 1:-1]).max() == 0.0
    back = derivation.angle(derivation.speed(angle))
    assert without(lost, back) == pytest.approx(without(lost, angle))
    assert derivation.centred_angle(derivation.speed(angle)) == pytest.approx(without(lost, angle))
    assert np.linalg.matrix_rank(np.vstack([lost, back - angle])) == len(lost)


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("n", [20, 21])
def test_the_adjoints(origin: SpeedOrigin, n: int) -> None:
    derivation, rng = Derivation(origin, H), np.random.default_rng(2)
    signal, weights = rng.standard_normal((2, 3, n))
    forward, back = np.sum(weights * derivation.speed(signal), axis=1), derivation.speed_adjoint(weights)
    assert np.sum(back * signal, axis=1) == pytest.approx(forward)
    forward, back = np.sum(weights * derivation.angle(signal), axis=1), derivation.angle_adjoint(weights)
    assert np.sum(back * signal, axis=1) == pytest.approx(forward)


@pytest.mark.parametrize("origin", ORIGINS)
def test_the_gain_of_white_noise(origin: SpeedOrigin) -> None:
    derivation, noise = Derivation(origin, H), np.random.default_rng(3).standard_normal(40_000)
    assert np.var(derivation.speed(noise)) == pytest.approx(derivation.gain, rel=0.03)
    omega = np.pi * (np.arange(500) + 0.5) / 500
    assert np.mean(derivation.squared(omega)) == pytest.approx(derivation.gain)
    wave = np.exp(1j * omega[100] * np.arange(50))
    shown = derivation.speed(wave.real)[20] ** 2 + derivation.speed(wave.imag)[20] ** 2
    assert derivation.squared(omega[100:101]) == pytest.approx([shown])


def test_only_a_record_without_a_sensor_of_speed_has_one() -> None:
    still = np.zeros(30)
    record = Record("r", "estimate", "both", H, still, still, still, speed_origin="backward difference")
    assert Derivation.of(record) == Derivation("backward difference", H)
    assert Derivation.of(replace(record, speed_origin="sensor")) is None
    assert Derivation.of(record, "position") is None
