"""The noise of a speed that is derived from the angle: blue from the encoder, and the torque's through the joint."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2
from support.extended_joint import values
from support.paper_joint import RATIO, STRUCTURE

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate.noise.averages import expected_levels
from robotid.estimate.noise.information import SeenDerivatives, is_explained
from robotid.estimate.noise.levels import fit_levels
from robotid.estimate.noise.lines import Residual
from robotid.estimate.noise.response import TorqueResponse, torque_response
from robotid.estimate.noise.whitening import InnovationsFilter, NoiseLevels, innovations_filter
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.derivation import Derivation
from robotid.signals.record import OPERATORS, Record, SpeedOrigin
from robotid.simulation.simulate import simulate

SAMPLES, SAMPLING_TIME = 4096, 0.002
SETTLED = 512  # samples after which the filter has forgotten where it started
ANGLE, TORQUE = 7e-6, 0.005  # standard deviations of the noise [rad, Nm]
BANDS, UNLIKELY = 16, 1e-4  # of a band to lie outside its limits by chance
ORIGINS: list[SpeedOrigin] = list(OPERATORS)
JOINTS = {
    "rigid": Structure(("motor.inertia", "motor.viscous", "motor.coulomb")),
    "flexible": STRUCTURE.without("gear.cubic_spring"),
    "undamped": Structure(("motor.inertia", "motor.viscous", "gear.spring", "arm.inertia"), gear_ratio=RATIO),
}


@cache
def response(name: str, origin: SpeedOrigin, *, angle: bool = True) -> TorqueResponse:
    joint = assemble(JOINTS[name], angle=angle)
    return torque_response(joint, values(joint), SAMPLING_TIME, "speed", Derivation(origin, SAMPLING_TIME))


@pytest.mark.parametrize("grows", [1e6, 1.1])
def test_a_joint_that_runs_away_within_a_sampling_time_has_no_response(grows: float) -> None:
    """By a factor of e, a bit more here, no controller that samples it would have held it."""
    joint = assemble(JOINTS["rigid"])
    driven = dict(zip(joint.names, values(joint).tolist(), strict=True))
    driven["motor.viscous.Fv"] = -grows * driven["motor.inertia.J"] / SAMPLING_TIME
    with pytest.raises(NumericsError, match="runs away"):
        torque_response(joint, np.array(list(driven.values())), SAMPLING_TIME, "speed")
    driven["motor.viscous.Fv"] *= 0.9 / grows
    assert torque_response(joint, np.array(list(driven.values())), SAMPLING_TIME, "speed").A.max() > 2.0


@cache
def turned(name: str, seed: int = 7) -> Array:
    """What a noise of the torque does to the angle of a joint that slips one way, (n,)."""
    joint = assemble(JOINTS[name], angle=True)
    theta = values(joint)
    still, noise = np.zeros(SAMPLES), TORQUE * np.random.default_rng(seed).standard_normal(SAMPLES)
    steady = Record("r", "estimate", "both", SAMPLING_TIME, still + 1.0, still, still)
    shaken = replace(steady, tau_m=1.0 + noise)
    x0 = np.zeros(joint.nx)
    x0[joint.speeds] = 20.0 * np.array([1.0, RATIO])[: joint.masses]
    return simulate(joint, theta, shaken, x0).phi_m - simulate(joint, theta, steady, x0).phi_m


def residual(name: str, origin: SpeedOrigin, *, torque: bool = True, seed: int = 7) -> Array:
    """Of the speed that is derived from the angle with both noises, (n,)."""
    angle = ANGLE * np.random.default_rng(seed + 100).standard_normal(SAMPLES)
    return Derivation(origin, SAMPLING_TIME).speed(angle + (turned(name, seed) if torque else 0.0))


def whitening(name: str, origin: SpeedOrigin, *, torque: bool = True) -> InnovationsFilter:
    return innovations_filter(response(name, origin), NoiseLevels(ANGLE**2, TORQUE**2 if torque else 0.0))


def likely(freedom: int) -> tuple[float, float]:
    """Between which a mean square of so many normal variables lies, but for UNLIKELY cases."""
    return float(chi2.ppf(UNLIKELY / 2, freedom)) / freedom, float(chi2.isf(UNLIKELY / 2, freedom)) / freedom


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("torque", [False, True], ids=["angle", "both"])
@pytest.mark.parametrize("name", JOINTS)
def test_the_spectrum_is_flat_and_the_energy_that_of_the_samples(name: str, torque: bool, origin: SpeedOrigin) -> None:
    whole = whitening(name, origin, torque=torque)(residual(name, origin, torque=torque))
    signal = whole[SETTLED:] if torque else whole
    power = np.abs(np.fft.rfft(signal)[1:-1]) ** 2 / len(signal)  # each line exponential, of mean 1
    for band in np.array_split(power, BANDS):
        low, high = likely(2 * len(band))
        assert low < band.mean() < high
    low, high = likely(len(signal))
    assert low < np.mean(signal**2) < high
    assert np.abs(whole).max() < 6.0  # at the ends, too


@pytest.mark.parametrize("origin", ORIGINS)
def test_believed_white_the_noise_of_the_encoder_is_far_off(origin: SpeedOrigin) -> None:
    """Else the test above would show nothing."""
    power = np.abs(np.fft.rfft(residual("rigid", origin, torque=False))[1:-1]) ** 2
    bands = [float(band.mean()) for band in np.array_split(power, BANDS)]
    assert max(bands) > 100 * bands[0]


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("name", ["rigid", "flexible"])
def test_the_levels_are_those_of_angle_and_torque(name: str, origin: SpeedOrigin) -> None:
    drawn = [Residual(residual(name, origin, seed=seed), response(name, origin)) for seed in (7, 8, 9)]
    for one, level in zip(drawn, fit_levels(drawn), strict=True):
        assert np.sqrt(level.output) == pytest.approx(ANGLE, rel=0.06)
        assert np.sqrt(level.torque + level.red) == pytest.approx(TORQUE, rel=0.15)
        assert is_explained(one, level)
    assert np.sqrt(expected_levels(drawn, fit_levels(drawn))[0].output) == pytest.approx(ANGLE, rel=0.06)


@pytest.mark.parametrize("origin", ORIGINS)
def test_nothing_is_found_on_the_torque_where_nothing_is(origin: SpeedOrigin) -> None:
    drawn = [Residual(residual("rigid", origin, torque=False, seed=k), response("rigid", origin)) for k in (1, 2, 3)]
    for level in fit_levels(drawn):
        assert np.sqrt(level.output) == pytest.approx(ANGLE, rel=0.05)
        assert level.torque == level.red == 0.0


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_part_of_a_record_shows_the_same_levels(origin: SpeedOrigin) -> None:
    """Its ends are not those at which a speed is derived in another way."""
    at = slice(700, 700 + 2048)
    drawn = [Residual(residual("rigid", origin, seed=seed)[at], response("rigid", origin)) for seed in (7, 8, 9)]
    for level in fit_levels(drawn):
        assert np.sqrt(level.output) == pytest.approx(ANGLE, rel=0.1)
        assert np.sqrt(level.torque + level.red) == pytest.approx(TORQUE, rel=0.2)


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("torque", [False, True])
def test_the_transposed_filter_is_the_adjoint(torque: bool, origin: SpeedOrigin) -> None:
    a, b = np.random.default_rng(3).standard_normal((2, 200))
    whiten = whitening("flexible", origin, torque=torque)
    assert a @ whiten(b) == pytest.approx(whiten.transposed(a) @ b, rel=1e-6)


@pytest.mark.parametrize("origin", ORIGINS)
def test_signals_are_filtered_row_by_row(origin: SpeedOrigin) -> None:
    whiten, one = whitening("flexible", origin), residual("flexible", origin)
    rows = np.stack([one, 2 * one, one[::-1]])
    assert whiten(rows)[1] == pytest.approx(2 * whiten(one))
    assert whiten(rows)[2] == pytest.approx(whiten(one[::-1].copy()))


@pytest.mark.parametrize("origin", ORIGINS)
def test_the_spread_of_an_estimate_is_that_of_repeated_draws(origin: SpeedOrigin) -> None:
    t = np.arange(SAMPLES) * SAMPLING_TIME
    columns = np.stack([np.sin(6 * t), np.sign(np.sin(4 * t)), np.cos(600 * t)])
    found = SeenDerivatives.of(columns, response("rigid", origin)).information(NoiseLevels(ANGLE**2, TORQUE**2))
    drawn = np.stack([columns @ residual("rigid", origin, seed=k) for k in range(60)])
    assert np.sqrt(np.diag(found)) == pytest.approx(np.sqrt(np.mean(drawn**2, axis=0)), rel=0.3)


@pytest.mark.parametrize("name", JOINTS)
def test_a_joint_without_its_angle_responds_alike(name: str) -> None:
    omega = np.geomspace(1e-2, 0.5, 20)
    with_angle, without_it = (response(name, "central difference", angle=kept) for kept in (True, False))
    assert without_it.squared(omega) == pytest.approx(with_angle.squared(omega), rel=0.1)


def test_the_same_noise_of_another_derivation() -> None:
    """An encoder has one noise, whatever comes of it; without any, a speed's white noise of the same variance."""
    found = whitening("rigid", "central difference")
    backward = Derivation("backward difference", 0.004)
    assert found.output_noise(backward) == ANGLE**2
    assert found.output_noise(None) == found.output_variance == pytest.approx(ANGLE**2 / 2 / SAMPLING_TIME**2)
    speed = innovations_filter(replace(response("rigid", "central difference"), derivation=None), NoiseLevels(2.0))
    assert speed.output_noise(None) == speed.output_variance == 2.0
    assert speed.output_noise(backward) == pytest.approx(2.0 / backward.gain)
