"""Noise of the torque as it passes along a motion that rests and reverses, told without a simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.noise.test_drawn import SAMPLES, SIZE, SPEED_NOISE, resting

from robotid.diagnosis.noise.colour import ColouredNoise, coloured_noise, slipping_share
from robotid.diagnosis.noise.whitening import Segment, with_typical_noise
from robotid.diagnosis.search import coloured
from robotid.diagnosis.search.coloured import Left, judged_along_the_motion
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.whitening import innovations_filter
from robotid.model.array import Array

NOTHING: Array = np.zeros((0, SAMPLES))


def slipping(*segments: SimulatedSegment) -> ColouredNoise:
    return coloured_noise(segments, [NOTHING] * len(segments), "speed")


def errors(noise: ColouredNoise, k: int = 0) -> float:
    """Standard deviation of the torque's errors [Nm]."""
    levels = noise.segments[k].whitening.levels
    return float(np.sqrt(levels.torque + levels.red))


def test_slow_errors_that_shift_reversals_have_their_size() -> None:
    rough = slipping(resting(1))
    found = rough.along_the_motion()
    assert not rough.linearly_explained
    assert found.linearly_explained
    assert errors(found) == pytest.approx(SIZE, rel=0.4)
    assert np.sqrt(found.segments[0].whitening.levels.output) == pytest.approx(SPEED_NOISE, rel=0.3)


def test_a_residual_of_such_noise_has_unit_energy() -> None:
    seen = resting(1)
    (segment,) = slipping(seen).along_the_motion().segments
    assert segment.whitening.excess > 1.2
    assert segment.energy(seen.residual) / SAMPLES == pytest.approx(1.0, abs=0.2)


def test_a_record_that_was_held_out_is_expected_to_be_as_loud() -> None:
    seen, other = resting(1), resting(2)
    found = slipping(seen).along_the_motion()
    theta = seen.trajectory.theta
    (held_out,) = with_typical_noise(found.segments, [other.record], seen.trajectory.joint, theta, "speed")
    assert held_out.energy(other.residual) / SAMPLES == pytest.approx(1.0, rel=0.7)


def test_errors_may_be_larger_in_one_record() -> None:
    quiet = resting(1)
    loud = resting(2)
    loud = replace(loud, record=replace(loud.record, name="loud"), residual=3.0 * loud.residual)
    found = slipping(quiet, loud).along_the_motion()
    assert found.linearly_explained
    assert errors(found, 1) > 2.0 * errors(found, 0)


def test_errors_that_are_small_in_the_others_are_no_bound_to_those_of_one_record() -> None:
    rough = slipping(resting(1))
    levels = rough.segments[0].whitening.levels
    common = replace(levels, torque=levels.torque / 100, red=levels.red / 100)
    quiet = Segment(rough.segments[0].record, innovations_filter(rough.residuals[0].response, common))
    found = replace(rough, segments=(quiet,)).along_the_motion()
    assert found.linearly_explained
    assert errors(found) == pytest.approx(SIZE, rel=0.4)


def test_a_misfit_at_the_same_places_is_none() -> None:
    """A dry friction that is wrong by five times the error of the torque."""
    assert not slipping(resting(1, 5 * SIZE)).along_the_motion().linearly_explained


def test_what_a_slipping_joint_explains_is_left_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = slipping(replace(resting(1), residual=SPEED_NOISE * np.random.default_rng(3).standard_normal(SAMPLES)))
    assert plain.linearly_explained
    monkeypatch.setattr(coloured.ColouredNoise, "along_the_motion", lambda _: pytest.fail("there is no need"))
    left = Left(None, plain, 1.0)  # type: ignore[arg-type]
    assert judged_along_the_motion(left) is left


def test_a_motor_that_rests_all_the_time_shows_no_error_of_its_torque() -> None:
    """Beside a record that moves, by levels that both have in common."""
    moving = resting(1)
    t = moving.trajectory
    still = replace(t, x=0.0 * t.x, dphi_m=0.0 * t.dphi_m, u=0.0 * t.u)
    rng = np.random.default_rng(2)
    at_rest = replace(moving, trajectory=still, residual=SPEED_NOISE * rng.standard_normal(SAMPLES))
    found = slipping(moving, at_rest)
    assert errors(found) > 0.3 * SIZE
    assert found.along_the_motion().linearly_explained
    assert 0.8 < slipping_share(t) < 0.95
    assert slipping_share(still) == 1 / SAMPLES
