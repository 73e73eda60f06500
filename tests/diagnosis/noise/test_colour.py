"""Noise of any colour, beside what columns explain."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter
from support.hidden_records import SPEED_NOISE, TORQUE_NOISE, hidden

from robotid.diagnosis.noise.colour import ColouredNoise, coloured_noise
from robotid.diagnosis.noise.noise_floor import noise_levels
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.response import torque_response
from robotid.model.array import Array
from robotid.signals.derivation import Derivation

NOTHING = np.zeros((0, 6000))


@cache
def segments(effect: str, value: float) -> tuple[SimulatedSegment, ...]:
    symbol = {"constant_torque": "tau0", "quadratic_friction": "Fq"}[effect]
    found = [hidden(effect, {symbol: value}, number=number) for number in (1, 2)]
    return tuple(segment for one in found for segment in one.simulated.segments("speed"))


CLEAN, WRONG = ("constant_torque", 0.0), ("quadratic_friction", 2e-4)


def derived(one: SimulatedSegment, angle: float, torque: float) -> SimulatedSegment:
    """The segment as a record of an angle alone, with white noises of these standard deviations [rad, Nm] only."""
    record, rng, n = (
        replace(one.record, speed_origin="central difference"),
        np.random.default_rng(12),
        len(one.residual),
    )
    derivation, t = Derivation.of(record), one.trajectory
    response = torque_response(t.joint, t.theta, t.sampling_time, "speed", derivation)
    x, found = np.zeros(len(response.b)), angle * rng.standard_normal(n)
    for k, u in enumerate((torque * rng.standard_normal(n)).tolist()):
        found[k] += x[response.row]
        x = response.A @ x + response.b * u
    assert derivation is not None
    record = replace(record, phi_m=record.phi_m + found)
    return replace(one, record=record, residual=derivation.speed(found))


def energy_a_sample(estimate: ColouredNoise, left: tuple[SimulatedSegment, ...]) -> float:
    energy = sum(one.energy(part.residual) for one, part in zip(estimate.segments, left, strict=True))
    return energy / sum(len(part.residual) for part in left)


def in_the_speed(one: SimulatedSegment, torque: Array) -> Array:
    """What a torque (n,) does to the speed."""
    t = one.trajectory
    response = torque_response(t.joint, t.theta, t.sampling_time, "speed")
    x, found = np.zeros(len(response.b)), np.zeros(len(torque))
    for k, u in enumerate(torque.tolist()):
        found[k] = x[response.row]
        x = response.A @ x + response.b * u
    return found


def test_a_residual_of_noise_has_the_noise_of_the_sensors() -> None:
    found = coloured_noise(segments(*CLEAN), [NOTHING] * 2, "speed")
    assert found.explained
    for segment in found.segments:
        assert np.sqrt(segment.whitening.levels.output) == pytest.approx(SPEED_NOISE, rel=0.05)
        assert np.sqrt(segment.whitening.levels.torque) == pytest.approx(TORQUE_NOISE, rel=0.4)
    assert energy_a_sample(found, segments(*CLEAN)) == pytest.approx(1.0, abs=0.05)


def test_what_columns_explain_is_no_noise() -> None:
    """Without them the misfit counts as an error of the torque: a test is blunter then, never sharper."""
    shape = [
        (wrong.residual - clean.residual)[None] for wrong, clean in zip(segments(*WRONG), segments(*CLEAN), strict=True)
    ]
    beside, without = (coloured_noise(segments(*WRONG), columns, "speed") for columns in (shape, [NOTHING] * 2))
    assert beside.explained
    assert energy_a_sample(beside, segments(*CLEAN)) == pytest.approx(1.0, abs=0.05)
    assert energy_a_sample(without, segments(*WRONG)) < 0.1 * energy_a_sample(beside, segments(*WRONG))


@pytest.mark.parametrize("torque", [0.0, TORQUE_NOISE])
def test_a_derived_speed_has_the_noise_of_its_angle(torque: float) -> None:
    angle = 7e-6
    seen = tuple(derived(one, angle, torque) for one in segments(*CLEAN))
    found = coloured_noise(seen, [NOTHING] * 2, "speed")
    assert found.explained
    assert energy_a_sample(found, seen) == pytest.approx(1.0, abs=0.05)
    for one, part, noise in zip(seen, found.segments, noise_levels(seen, "speed"), strict=True):
        assert np.sqrt(part.whitening.levels.output) == pytest.approx(angle, rel=0.05)
        assert noise.alone
        assert noise.output == pytest.approx(np.sqrt(part.whitening.output_variance), rel=0.05)
        assert noise.torque == pytest.approx(torque, abs=0.3 * TORQUE_NOISE)
        assert noise.floor == pytest.approx(float(np.std(one.residual)), rel=0.03)


def test_the_least_noise_of_a_derived_speed_is_the_quantum_of_the_angle() -> None:
    first = derived(segments(*CLEAN)[0], 7e-6, 0.0)
    quantum = 2 * np.pi / 2**12
    record = replace(first.record, phi_m=quantum * np.round(first.record.phi_m / quantum))
    found = coloured_noise((replace(first, record=record),), [NOTHING], "speed")
    assert found.segments[0].whitening.levels.output == pytest.approx(quantum**2 / 12, rel=1e-6)


def test_red_errors_of_the_torque_are_noise() -> None:
    rng, pole, size = np.random.default_rng(3), 0.99, 0.05
    loud = []
    for one in segments(*CLEAN):
        error = size * np.sqrt(1 - pole**2) * lfilter([1.0], [1.0, -pole], rng.standard_normal(len(one.residual)))
        loud.append(replace(one, residual=one.residual + in_the_speed(one, error)))
    found = coloured_noise(loud, [NOTHING] * 2, "speed")
    assert found.explained
    assert energy_a_sample(found, tuple(loud)) == pytest.approx(1.0, abs=0.05)
    assert np.sqrt(found.segments[0].whitening.levels.red) == pytest.approx(size, rel=0.5)


def test_a_segment_at_rest_does_not_have_much_less_noise_than_the_others() -> None:
    first, second = segments(*CLEAN)
    still = replace(second, residual=1e-3 * second.residual)
    found = coloured_noise((first, first, still), [NOTHING] * 3, "speed")
    levels = [np.sqrt(segment.whitening.levels.output) for segment in found.segments]
    assert levels[2] == pytest.approx(0.25 * levels[0], rel=0.05)


@pytest.mark.parametrize("factor", [1.0, 6.0])
def test_errors_of_the_torque_may_be_larger_in_one_record(factor: float) -> None:
    rng, made = np.random.default_rng(5), []
    for k, one in enumerate(segments(*CLEAN)):
        red = lfilter([np.sqrt(1 - 0.95**2)], [1.0, -0.95], rng.standard_normal(len(one.residual) + 500))[500:]
        error = 0.03 * (factor if k else 1.0) * red
        made.append(replace(one, residual=one.residual + in_the_speed(one, error)))
    found = coloured_noise(tuple(made), [NOTHING] * 2, "speed")
    assert found.linearly_explained
    first, second = (np.sqrt(one.whitening.levels.red) for one in found.segments)
    assert second / first == pytest.approx(factor, rel=0.25 if factor > 1 else 1e-9)
    assert first == pytest.approx(0.03, rel=0.3)
