"""The noise is told from the misfit, whether there is one or not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.hidden_records import SPEED_NOISE, TORQUE_NOISE, Hidden, hidden
from support.paper_joint import SAMPLING_TIME, references

from robotid.diagnosis.noise.noise_floor import noise_levels
from robotid.diagnosis.noise.spectrum import residual_spectrum
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.signals.reference import Reference

NOTHING = {"tau0": 0.0}


def segment(found: Hidden) -> SimulatedSegment:
    return SimulatedSegment(found.record, found.simulated.trajectories[0], found.residual())


@cache
def truth(number: int, torque_noise: float = TORQUE_NOISE) -> float:
    """RMS error of the true model."""
    return float(np.std(hidden("constant_torque", NOTHING, number=number, torque_noise=torque_noise).residual()))


@pytest.mark.parametrize("number", [1, 2, 3])
def test_all_of_a_true_models_error_is_noise(number: int) -> None:
    found = hidden("constant_torque", NOTHING, number=number)
    (noise,) = noise_levels([segment(found)], "speed")
    assert noise.alone
    assert noise.floor == pytest.approx(float(np.std(found.residual())), rel=0.1)
    assert noise.output == pytest.approx(SPEED_NOISE, rel=0.05)


def test_both_noises_are_told_apart_where_both_show() -> None:
    found = hidden("constant_torque", NOTHING, number=1, samples=12_000, torque_noise=0.05, speed_noise=0.005)
    (noise,) = noise_levels([segment(found)], "speed")
    assert noise.torque == pytest.approx(0.05, rel=0.15)
    assert noise.output == pytest.approx(0.005, rel=0.1)
    assert noise.floor == pytest.approx(float(np.std(found.residual())), rel=0.2)


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("stribeck", {"dFs": 0.15, "vs": 2.0}),
        ("cogging", {"A": 0.05, "B": 0.02, "n": 6.0}),
        ("quadratic_friction", {"Fq": 2e-4}),
        ("constant_torque", {"tau0": 0.1}),
    ],
)
def test_a_misfit_does_not_raise_the_floor(effect: str, values: dict[str, float]) -> None:
    found = [hidden(effect, values, number=number) for number in (1, 2, 3)]
    for number, noise in zip((1, 2, 3), noise_levels([segment(one) for one in found], "speed"), strict=True):
        assert noise.floor == pytest.approx(truth(number), rel=0.2)


def test_periods_show_the_noise_behind_a_misfit() -> None:
    reference = Reference("periodic", SAMPLING_TIME, np.tile(references()[2][:2000], 6), "speed", period=1.0)
    found = hidden("quadratic_friction", {"Fq": 2e-4}, reference=reference, torque_noise=0.05)
    (noise,) = noise_levels([segment(found)], "speed")
    assert not noise.alone
    assert noise.torque == pytest.approx(0.05, rel=0.35)


def test_periods_that_are_the_same_to_the_last_step_show_no_noise_and_are_not_asked() -> None:
    reference = Reference("periodic", SAMPLING_TIME, np.tile(references()[2][:2000], 6), "speed", period=1.0)
    found = hidden("quadratic_friction", {"Fq": 2e-4}, reference=reference)
    once = found.residual()[-2000:]
    record = replace(found.record, period=1.0)
    seen = SimulatedSegment(record, found.simulated.trajectories[0], np.tile(once, len(record) // 2000))
    assert noise_levels([seen], "speed")[0].output > 0.1 * SPEED_NOISE


def test_the_quantum_of_a_derived_speed_is_noise() -> None:
    clean = hidden("constant_torque", NOTHING)
    coarse = 2e-3 * np.round(clean.record.phi_m / 2e-3)
    residual = np.gradient(coarse, SAMPLING_TIME) - clean.simulated.signal("speed")
    floor = noise_levels([SimulatedSegment(clean.record, clean.simulated.trajectories[0], residual)], "speed")[0].floor
    assert floor == pytest.approx(float(np.std(residual)), rel=0.2)
    assert floor > 10 * SPEED_NOISE


def test_without_a_residual_there_is_no_noise() -> None:
    found = hidden("constant_torque", NOTHING)
    exact = SimulatedSegment(found.record, found.simulated.trajectories[0], np.zeros(6000))
    assert noise_levels([exact], "speed")[0].floor == 0.0


def test_the_torques_noise_counts_by_what_it_does_to_the_output() -> None:
    assert truth(1, torque_noise=10 * TORQUE_NOISE) > 1.2 * SPEED_NOISE


def test_records_that_agree_show_a_noise_of_the_torque_that_each_alone_hides() -> None:
    segments = [segment(hidden("constant_torque", NOTHING, number=number)) for number in (1, 2, 3)]
    assert min(noise_levels([one], "speed")[0].torque for one in segments) == 0.0
    assert [noise.torque for noise in noise_levels(segments, "speed")] == pytest.approx([TORQUE_NOISE] * 3, rel=0.4)


def test_a_record_with_a_misfit_has_the_noise_of_the_torque_that_the_others_agree_on() -> None:
    clean = [segment(hidden("constant_torque", NOTHING, number=number)) for number in (1, 2)]
    wrong = segment(hidden("constant_torque", {"tau0": 0.1}, number=3))
    assert noise_levels([wrong], "speed")[0].torque > 5 * TORQUE_NOISE
    found = [noise.torque for noise in noise_levels([*clean, wrong], "speed")]
    assert found == pytest.approx([TORQUE_NOISE] * 3, rel=0.4)


def test_a_joint_that_runs_away_has_a_finite_response() -> None:
    """Its answer to an impulse grows without end, that to a steady sine does not."""
    found = segment(hidden("constant_torque", NOTHING, number=1)).trajectory
    theta = found.theta.copy()
    theta[found.joint.parameters().names.index("motor.viscous.Fv")] = -1.0
    seen = residual_spectrum(replace(found, theta=theta), np.ones(len(found.t)), "speed")
    assert np.isfinite(seen.response).all()
    assert seen.response[1:].min() > 0.0
