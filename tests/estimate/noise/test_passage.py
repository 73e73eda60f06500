"""Noise of the torque along a motion with reversals, against repeated simulations."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

from robotid.catalogue import assemble
from robotid.estimate.noise.lines import Innovations, Residual
from robotid.estimate.noise.passage import TorquePassage, passed_noise
from robotid.estimate.noise.passed import PassedNoise
from robotid.estimate.noise.response import TorqueResponse, torque_response
from robotid.estimate.noise.reversals import MOST, reversal_columns
from robotid.estimate.noise.settings import SETTINGS
from robotid.estimate.noise.whitening import NoiseLevels, innovations_filter
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.derivation import Derivation
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

H, N, POLE, CORNER = 1e-3, 4000, 0.99, 10.05
JOINT = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
THETA = (
    JOINT.parameters().with_values({"motor.inertia.J": 2e-3, "motor.viscous.Fv": 4e-3, "motor.coulomb.Fc": 0.2}).values
)
T = np.arange(N) * H
TORQUE = 0.25 * np.sin(2 * np.pi * 1.3 * T)  # reversals and standstill


def record(error: Array | float = 0.0) -> Record:
    found = Record("r", "estimate", "both", H, TORQUE + error, 0 * T, 0 * T)
    return replace(found, dphi_m=motion(found).dphi_m)


def motion(of: Record) -> Trajectory:
    return simulate(JOINT, THETA, of, x0=np.zeros(JOINT.nx))


@cache
def simulated() -> Trajectory:
    return motion(record())


@cache
def residual(derived: bool) -> Residual:
    origin = Derivation("central difference", H) if derived else None
    response = torque_response(JOINT, THETA, H, "speed", origin)
    return Residual(np.zeros(N), response, np.ones((1, N)))


def errors(red: bool, seed: int, size: float = 1e-5) -> Array:
    """So small that the motion answers linearly."""
    white = np.random.default_rng(seed).standard_normal(N + 2000)
    return size * (lfilter([np.sqrt(1 - POLE**2)], [1.0, -POLE], white) if red else white)[2000:]


@pytest.mark.parametrize("derived", [False, True], ids=["measured", "derived"])
def test_steps_that_are_kept_are_linearised_once(derived: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    passage = TorquePassage.of(simulated(), "speed", derived=derived)
    n = len(simulated().u)
    weights = np.random.default_rng(3).standard_normal((2, n))
    expected = passage.adjoint(weights)
    kept = passage.kept()
    assert kept.kept() is kept
    assert kept.part(slice(0, n)) is kept
    assert kept.part(slice(0, n // 2)).steps is None  # the last steps of a part are others
    monkeypatch.setattr(Trajectory, "linearise", None)
    np.testing.assert_array_equal(kept.adjoint(weights), expected)


@pytest.mark.parametrize("red", [False, True], ids=["white", "red"])
@pytest.mark.parametrize("derived", [False, True], ids=["measured", "derived"])
def test_the_spectrum_is_that_of_repeated_simulations(*, red: bool, derived: bool) -> None:
    one = residual(derived)
    whiten = innovations_filter(one.response, NoiseLevels(1e-12 if derived else 1e-6, 1e-6))
    passage = TorquePassage.of(simulated(), "speed", derived=derived)
    passed = passed_noise(one, whiten, passage)
    assert passed is not None
    expected = replace(one, passed=passed)
    powers, count = [], 40
    for seed in range(count):
        shown = motion(record(errors(red, seed))).dphi_m - simulated().dphi_m
        if derived:
            shown = shown_by(one.response, shown)
        found = Innovations.of(replace(one, signal=shown / 1e-5), whiten, SETTINGS)
        powers.append(found.power)
    white, reds = found.of_the_torque(expected, np.array([CORNER]))
    model, mean = (reds[0] if red else white), np.mean(powers, axis=0)
    for band in np.array_split(np.flatnonzero(model > 0.1 * model[:20].mean()), 8):
        assert mean[band].mean() == pytest.approx(model[band].mean(), rel=0.25)


def shown_by(response: TorqueResponse, speed: Array) -> Array:
    """The derived speed of a deviation whose own speed is given, (n,)."""
    assert response.derivation is not None
    angle = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) * H / 2)])
    return response.derivation.speed(angle)


def test_a_joint_that_always_slips_shows_what_its_response_says() -> None:
    smooth = assemble(Structure(("motor.inertia", "motor.viscous")))
    theta = smooth.parameters().with_values({"motor.inertia.J": 2e-3, "motor.viscous.Fv": 4e-2}).values
    response = torque_response(smooth, theta, H, "speed")
    found = simulate(smooth, theta, record(), x0=np.zeros(smooth.nx))
    one, whiten = Residual(np.zeros(N), response, np.zeros((0, N))), innovations_filter(response, NoiseLevels(1.0))
    passed = passed_noise(one, whiten, TorquePassage.of(found, "speed", derived=False))
    assert passed is not None
    factors = passed.factors(np.array([CORNER]), 2 * np.pi * np.arange(8, N // 2) / N)
    assert factors == pytest.approx(np.ones(factors.shape), rel=0.1)


def test_without_a_response_nothing_is_more() -> None:
    nothing = PassedNoise(H, np.array([1.0]), np.zeros((1, 1)), np.ones(1), np.ones(1), np.zeros(1))
    assert nothing.factors(np.zeros(0), np.array([0.5])) == pytest.approx(np.ones((1, 1)))


def test_torques_at_reversals_are_unknown_sample_by_sample() -> None:
    held = record()
    columns = reversal_columns(held, simulated(), residual(False).response, slice(0, N))
    moving = np.abs(held.dphi_m) > 0.0
    apart = int(np.sum(~(moving[:-1] & moving[1:] & (held.dphi_m[:-1] * held.dphi_m[1:] > 0.0))))
    assert 0 < len(columns) <= MOST < apart  # standstill is longer: several samples are taken together
    assert reversal_columns(held, simulated(), residual(False).response, slice(0, 100)).shape[1] == 100


def test_a_joint_without_dry_friction_has_no_unknown_torques() -> None:
    smooth = assemble(Structure(("motor.inertia", "motor.viscous")))
    theta = smooth.parameters().with_values({"motor.inertia.J": 2e-3, "motor.viscous.Fv": 4e-2}).values
    response = torque_response(smooth, theta, H, "speed")
    found = simulate(smooth, theta, record(), x0=np.zeros(smooth.nx))
    assert reversal_columns(record(), found, response, slice(0, N)).shape == (0, N)


def test_where_runs_are_too_many_no_torque_counts_as_unknown() -> None:
    one = record()
    shaking = replace(one, dphi_m=np.where(np.arange(N) % 4 < 2, 1.0, -1.0))
    moving = replace(simulated(), dphi_m=np.ones(N))
    assert len(reversal_columns(shaking, moving, residual(False).response, slice(0, N))) == 0
