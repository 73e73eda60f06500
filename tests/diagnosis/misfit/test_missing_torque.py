"""The torque of a hidden effect is found again from what a model without it gets wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.hidden_records import QUANTUM, SPEED_NOISE, TORQUE_NOISE, Hidden, hidden

from robotid.diagnosis.misfit.missing_torque import MissingTorque, missing_torque
from robotid.estimate.fitted_model import simulate_record
from robotid.signals.derivation import Derivation
from robotid.signals.record import OPERATORS, SpeedOrigin


def find(case: Hidden) -> MissingTorque:
    [segment] = case.simulated.segments("speed")
    return missing_torque(segment, "speed", SPEED_NOISE, TORQUE_NOISE)


@pytest.mark.parametrize(
    ("effect", "values", "number", "least"),
    [
        ("quadratic_friction", {"Fq": 2e-4}, 1, 0.99),
        ("position_friction", {"A": 0.05, "B": 0.02, "n": 1.0}, 2, 0.99),
        ("cogging", {"A": 0.05, "B": 0.02, "n": 6.0}, 2, 0.95),
        ("stribeck", {"dFs": 0.15, "vs": 2.0}, 1, 0.95),
    ],
)
def test_it_follows_the_hidden_torque(effect: str, values: dict[str, float], number: int, least: float) -> None:
    case = hidden(effect, values, number=number)
    found, at = find(case), case.moving
    assert np.corrcoef(found.torque[at], case.missing[at])[0, 1] > least


def test_a_constant_does_not_drift_though_the_model_reverses_at_other_times() -> None:
    case = hidden("constant_torque", {"tau0": 0.1}, number=2)
    assert np.std(case.residual()) > 1.0
    torque = find(case).torque
    assert torque[0] == pytest.approx(-0.1, abs=0.01)
    assert torque[-1] == pytest.approx(-0.1, abs=0.01)
    assert np.abs(torque + 0.1).max() < 0.01


@pytest.mark.parametrize("number", [1, 3])
def test_noise_asks_for_no_torque(number: int) -> None:
    case = hidden("constant_torque", {"tau0": 0.0}, number=number)
    assert np.sqrt(np.mean(find(case).torque ** 2)) < 0.002


def test_position_tells_it_too() -> None:
    case = hidden("quadratic_friction", {"Fq": 2e-4}, output="position")
    [segment], noise = case.simulated.segments("position"), QUANTUM / np.sqrt(12)
    found = missing_torque(segment, "position", noise, TORQUE_NOISE)
    assert np.corrcoef(found.torque[case.moving], case.missing[case.moving])[0, 1] > 0.99


@pytest.mark.parametrize("origin", list(OPERATORS))
def test_a_speed_that_is_derived_from_the_angle_tells_it_too(origin: SpeedOrigin) -> None:
    case = hidden("quadratic_friction", {"Fq": 2e-4}, output="position")
    derivation = Derivation(origin, case.record.sampling_time)
    record = replace(case.record, dphi_m=derivation.speed(case.record.phi_m), speed_origin=origin)
    [segment] = simulate_record(replace(case.model, output="speed"), record).segments("speed")
    noise = float(np.sqrt(derivation.gain / 12)) * QUANTUM
    found = missing_torque(segment, "speed", noise, TORQUE_NOISE)
    assert np.corrcoef(found.torque[case.moving], case.missing[case.moving])[0, 1] > 0.99


def test_with_the_torque_added_the_model_moves_as_measured() -> None:
    case = hidden("cogging", {"A": 0.05, "B": 0.02, "n": 6.0}, number=2)
    left = case.record.dphi_m - find(case).x[case.model.joint.motor_speed]
    assert np.std(case.residual()) > 3 * SPEED_NOISE
    assert np.std(left) == pytest.approx(SPEED_NOISE, rel=0.05)
