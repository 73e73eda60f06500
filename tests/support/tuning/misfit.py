"""Checks of the constants of the misfit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.diagnosis.misfit import missing_torque as missing
from robotid.diagnosis.misfit.bins import bin_edges
from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.misfit.location import locate
from robotid.diagnosis.misfit.missing_torque import MissingTorque, _likeliest
from robotid.diagnosis.misfit.settings import MISFIT
from robotid.diagnosis.misfit.smoother import Chain, Smoothed
from robotid.diagnosis.misfit.summary import limited_floors
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array
from robotid.simulation.simulate import simulate
from support.plain_models import AXIS, plain_record
from support.tuning import sees

N, H = 4000, 0.01
TIME = H * np.arange(N)


@cache
def turning(turns: float = 20.0) -> SimulatedSegment:
    """The axis as it turns to and fro so far, whatever torque that takes."""
    joint = assemble(AXIS, angle=True)
    still = simulate(joint, joint.parameters().values, plain_record(N))
    angle = np.pi * turns * np.sin(2 * np.pi * TIME / 10.0)
    speed = np.gradient(angle, H)
    record = replace(plain_record(N), phi_m=angle, dphi_m=speed)
    x = np.stack([angle, speed])
    return SimulatedSegment(record, replace(still, x=x, phi_m=angle, dphi_m=speed), np.zeros(N))


def curves(torque: Array, segment: SimulatedSegment | None = None) -> dict[str, Curve]:
    one = segment or turning()
    return {curve.along: curve for curve in locate([MissingTorque(one, torque, one.trajectory.x)])}


def noise(seed: int = 1) -> Array:
    return np.random.default_rng(seed).standard_normal(N)


def chain(step: float) -> Chain:
    """An axis of unit inertia under a torque that changes by such steps, its speed seen through little noise."""
    rng = np.random.default_rng(4)
    w = np.cumsum(step * rng.standard_normal(N))
    y = np.cumsum(w) + 1e-3 * rng.standard_normal(N)
    ones, nothing = np.ones((1, N - 1)), np.zeros((1, N - 1))
    return Chain(ones[None], nothing, ones, y, 0, 1e-3, 0.0, np.zeros(1), np.array([np.abs(y).max()]), 1.0)


@sees(MISFIT, "coarse_powers")
def check_steps_of_a_torque_are_found_over_six_powers_of_ten() -> None:
    for power in (-3.0, -5.0, -7.0):
        found = _likeliest(chain(10.0**power), np.array(missing.MISFIT.coarse_powers))
        assert found == pytest.approx(power, abs=1.0)


def smoothed(evidences: list[float], residual: float, output_noise: float) -> list[Array]:
    """The powers that are tried, linearisation by linearisation, where they lead to these evidences."""
    tried, answers = list[Array](), iter(evidences)

    def likeliest(_: Chain, powers: Array) -> float:
        tried.append(powers)
        return float(powers[len(powers) // 2])

    one = turning()
    nothing = np.zeros(N)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(missing, "_as_measured", lambda *_: one.trajectory.x)
        patch.setattr(missing, "_linearised", lambda *_: (np.ones((1, 1, 1)), np.ones((1, 1)), np.ones((1, 1))))
        patch.setattr(missing, "_likeliest", likeliest)
        patch.setattr(Chain, "smooth", lambda *_: Smoothed(one.trajectory.x, nothing, next(answers)))
        wave = replace(one, residual=np.where(np.arange(N) % 2, residual, -residual))
        missing.missing_torque(wave, "speed", output_noise)
    return tried


@sees(MISFIT, "fine_powers")
def check_a_step_is_refined_by_a_factor_of_four_either_way() -> None:
    tried = smoothed([1.0, 0.0, 100.0, 200.0], 10.0, 1.0)
    assert np.ptp(10.0 ** (tried[2] - tried[2][1])) == pytest.approx(4.0, rel=0.1)


@sees(MISFIT, "max_sweeps")
def check_a_torque_is_linearised_twice_again() -> None:
    assert len(smoothed([0.0, 1.0, *np.arange(10.0, 200.0, 10.0)], 10.0, 1.0)) == 2 + 2


@sees(MISFIT, "telling_evidence")
def check_a_sweep_that_is_less_than_e_times_as_likely_is_the_last() -> None:
    assert len(smoothed([0.0, 0.0, 0.9, 50.0], 10.0, 1.0)) == 2 + 1
    assert len(smoothed([0.0, 0.0, 1.1, 50.0], 10.0, 1.0)) == 2 + 2


@sees(MISFIT, "small_residual")
def check_a_model_within_half_more_than_the_noise_moves_as_measured() -> None:
    assert len(smoothed([0.0] * 4, 1.4, 1.0)) == 1
    assert len(smoothed([0.0] * 4, 1.6, 1.0)) > 1


@sees(MISFIT, "least_noise")
def check_a_record_without_noise_has_a_billionth_of_it() -> None:
    used = list[Any]()

    def likeliest(one: Chain, powers: Array) -> float:
        used.append(one.output / np.abs(turning().trajectory.x[1]).max())
        return -3.0

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(missing, "_likeliest", likeliest)
        smooth = Smoothed(turning().trajectory.x, np.zeros(N), 0.0)
        patch.setattr(missing, "_as_measured", lambda *_: turning().trajectory.x)
        patch.setattr(missing, "_linearised", lambda *_: (np.ones((1, 1, 1)), np.ones((1, 1)), np.ones((1, 1))))
        patch.setattr(Chain, "smooth", lambda *_: smooth)
        missing.missing_torque(turning(), "speed", 0.0)
    assert used[0] == pytest.approx(1e-9, abs=0.0)


@sees(MISFIT, "max_floor_ratio")
def check_no_record_has_far_more_noise_than_the_quietest() -> None:
    assert limited_floors({"a": 1.0, "b": 1.4, "c": 9.0}) == pytest.approx({"a": 1.0, "b": 1.4, "c": 1.5})


@sees(MISFIT, "excerpt")
def check_the_step_is_chosen_by_half_a_minute_at_most() -> None:
    long = replace(chain(1e-3), y=np.zeros(20_000), G=np.ones((1, 1, 19_999)), g=np.zeros((1, 19_999)))
    assert len(replace(long, b=np.ones((1, 19_999))).excerpt().y) == 5000  # of 200 to 1000 samples a second


@sees(MISFIT, "bins")
def check_a_curve_has_as_many_bins_as_a_figure_shows() -> None:
    assert 20 <= len(bin_edges(np.random.default_rng(1).uniform(0.0, 1.0, 50_000) ** 2, False)) <= 40


@sees(MISFIT, "least_bin_share")
def check_no_bin_has_less_than_a_four_hundredth_of_the_samples() -> None:
    x = np.random.default_rng(1).uniform(0.0, 1.0, 40_000) ** 6
    least = np.histogram(x, bin_edges(x, False))[0].min()
    assert 40_000 / 400 <= least < 3 * 40_000 / 400


@sees(MISFIT, "finest_bin")
def check_bins_beside_zero_are_a_hundredth_of_the_largest_value() -> None:
    x = np.linspace(-1.0, 1.0, 100_001)
    edges = bin_edges(x, True)
    assert edges[edges > 1e-12].min() == pytest.approx(0.01, rel=0.05)


@sees(MISFIT, "standstill")
def check_samples_slower_than_a_thousandth_are_not_counted() -> None:
    one = turning()
    slow = np.where(np.arange(N) < 1000, 0.8e-3, np.where(np.arange(N) < 2000, 1.5e-3, 1.0))
    x = np.stack([one.trajectory.x[0], slow])
    (curve,) = [c for c in locate([MissingTorque(one, noise(), x)]) if c.along == "phi_m"]
    assert curve.count.sum() == 3000


@sees(MISFIT, "min_turns")
def check_what_repeats_every_turn_shows_after_two() -> None:
    assert "phi_m mod 2 pi" not in curves(noise(), turning(1.8))
    assert "phi_m mod 2 pi" in curves(noise(), turning(2.2))


@sees(MISFIT, "bins_a_turn")
def check_a_turn_is_seen_every_ten_degrees() -> None:
    assert len(curves(noise())["phi_m mod 2 pi"].x) == 36


@sees(MISFIT, "blocks")
def check_a_twentieth_of_a_record_is_predicted_from_the_rest() -> None:
    # a torque that is there in one part only: within a block nothing else tells of it, across some blocks it does
    def order(blocks: float) -> float:
        return curves(np.where(blocks * N * H / 20 > TIME, 1.0, 0.0))["t"].order

    assert order(1.0) < 0.1
    assert order(3.0) > 0.5


@sees(MISFIT, "rare_share")
def check_a_bin_with_a_thousandth_of_the_fullest_is_filled_by_its_neighbours() -> None:
    from robotid.diagnosis.misfit.location import _ratio

    own = np.array([1000.0, 0.8, 1000.0])
    at = np.arange(3.0)
    assert _ratio(np.array([1000.0, 8.0, 1000.0]), own, at, False)[1] == pytest.approx(1.0)
    own[1] = 1.5
    assert _ratio(np.array([1000.0, 15.0, 1000.0]), own, at, False)[1] == pytest.approx(10.0)


@sees(MISFIT, "bands_an_octave")
def check_frequencies_are_shown_in_half_octaves() -> None:
    x = curves(noise())["frequency"].x
    assert x[-1] / x[-2] == pytest.approx(np.sqrt(2.0), rel=0.02)
