"""The levels of the noises that make a residual, and the filter that they ask for."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import nnls
from scipy.signal import lfilter
from scipy.stats import kstest

from robotid.estimate.noise.averages import expected_levels, likely_levels
from robotid.estimate.noise.floor import torque_floor
from robotid.estimate.noise.information import SeenDerivatives, are_explained, is_explained
from robotid.estimate.noise.levels import _apart, _least_squares, _likeliest, _Shapes, choices, fit_levels, whitened
from robotid.estimate.noise.lines import Innovations, Residual
from robotid.estimate.noise.response import TorqueResponse
from robotid.estimate.noise.settings import SETTINGS, LevelSettings
from robotid.estimate.noise.whitening import NoiseLevels, innovations_filter
from robotid.model.array import Array

H, SAMPLES = 1e-3, 4000
J, FV, RATIO, JA, K1, D = 0.0121, 0.013, 1 / 224.3, 1130.0, 1.46e6, 2630.0
NOISE = {"speed": 0.02, "position": 7e-6}
ROW = {"speed": 2, "position": 0}


@cache
def joint(output: str) -> TorqueResponse:
    """The paper's joint, states (phi_m, twist, dphi_m, dphi_a), written out."""
    dynamics = np.array(
        [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, RATIO, -1.0],
            [0.0, -RATIO * K1 / J, -(FV + RATIO**2 * D) / J, RATIO * D / J],
            [0.0, K1 / JA, RATIO * D / JA, -D / JA],
        ]
    )
    block = np.zeros((5, 5))
    block[:4, :4], block[2, 4] = dynamics, 1 / J
    stepped = expm(block * H)
    first = 0 if output == "position" else 1
    return TorqueResponse(stepped[first:4, first:4], stepped[first:4, 4], ROW[output] - first, H)


def residual(output: str, rng: np.random.Generator, torque: float, red: float, pole: float) -> Array:
    """What an output shows of a noise of its own and of the torque's, (n,)."""
    drive = torque * rng.standard_normal(SAMPLES)
    coloured = lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], rng.standard_normal(SAMPLES + 2000))[2000:]
    response, x = joint(output), np.zeros(len(joint(output).b))
    y = np.empty(SAMPLES)
    for k, u in enumerate(drive + red * coloured):
        y[k] = x[response.row]
        x = response.A @ x + response.b * u
    return y + NOISE[output] * rng.standard_normal(SAMPLES)


def residuals(output: str, torque: float, red: float = 0.0, pole: float = 0.9, seed: int = 1) -> list[Residual]:
    rng = np.random.default_rng(seed)
    return [Residual(residual(output, rng, torque, red, pole), joint(output)) for _ in range(3)]


def test_the_noise_of_a_few_samples_shows_where_columns_take_most_of_every_frequency() -> None:
    """Half of 200 samples, the middle ones, hold nine tenths of what a taper passes."""
    rng, taken = np.random.default_rng(5), np.eye(200)[48:152]
    found = [
        fit_levels([Residual(residual("speed", rng, 0.0, 0.0, 0.0)[:200], joint("speed"), taken)])[0].output
        for _ in range(20)
    ]
    assert 0.5 < np.sqrt(np.median(found)) / NOISE["speed"] < 2.0


def test_a_residual_of_few_steps_has_levels_beside_columns_of_any_size() -> None:
    """Of an encoder so coarse that most of its differences are none, the finest would be of no size at all."""
    steps = np.cumsum(np.random.default_rng(6).random(SAMPLES) < 0.01) * NOISE["speed"]
    seen = Residual(steps - steps.mean(), joint("speed"), 1e10 * np.eye(SAMPLES)[::400])
    assert np.median(np.abs(np.diff(steps, 2))) == 0.0
    (found,) = fit_levels([seen])
    assert 0.0 < found.output < np.mean(seen.signal**2)


def test_a_residual_that_is_mostly_nothing_is_not_clipped_to_nothing() -> None:
    """A motor that rests for most of a record, as its simulation does, leaves nothing there."""
    signal = NOISE["speed"] * np.random.default_rng(7).standard_normal(SAMPLES)
    signal[SAMPLES // 4 :] = 0.0
    white = innovations_filter(joint("speed"), NoiseLevels(1.0))
    clipped = Innovations.of(Residual(signal, joint("speed")), white, LevelSettings(clip=4.0))
    assert clipped.energy == pytest.approx(0.25 * NOISE["speed"] ** 2, rel=0.2)


def test_a_silent_residual_has_the_noise_of_the_others() -> None:
    """Else what shows of the torque in a piece in which all rests would count without end."""
    rng = np.random.default_rng(8)
    loud = [Residual(residual("speed", rng, 0.0, 0.0, 0.0), joint("speed")) for _ in range(2)]
    first, silent, second = fit_levels([loud[0], Residual(np.zeros(SAMPLES), joint("speed")), loud[1]])
    assert silent.output == pytest.approx((first.output + second.output) / 2)


def test_an_output_without_noise_is_whitened_beside_that_of_the_torque() -> None:
    whiten = innovations_filter(joint("speed"), NoiseLevels(0.0, 0.01))
    left = whiten(residual("speed", np.random.default_rng(9), 0.1, 0.0, 0.0))
    assert np.isfinite(left).all()
    assert whiten.levels.output > 0.0


@pytest.mark.parametrize(("output", "torque"), [("speed", 0.03), ("position", 0.005)])
def test_white_noise_of_output_and_torque(output: str, torque: float) -> None:
    for one in fit_levels(residuals(output, torque)):
        assert np.sqrt(one.output) == pytest.approx(NOISE[output], rel=0.06)
        assert np.sqrt(one.torque) == pytest.approx(torque, rel=0.15)
        assert one.red == 0.0


@pytest.mark.parametrize("output", ["speed", "position"])
def test_nothing_is_found_on_the_torque_where_nothing_is(output: str) -> None:
    for one in fit_levels(residuals(output, 0.0)):
        assert np.sqrt(one.output) == pytest.approx(NOISE[output], rel=0.05)
        assert one.torque == one.red == 0.0


@pytest.mark.parametrize("output", ["speed", "position"])
@pytest.mark.parametrize("pole", [0.9, 0.99])
def test_red_noise_of_the_torque(output: str, pole: float) -> None:
    """White and red together do what both do in truth, though one may stand in for a part of the other."""
    drawn = residuals(output, 0.005, 0.02, pole)
    levels = fit_levels(drawn)
    assert np.sqrt(levels[0].torque + levels[0].red) == pytest.approx(np.hypot(0.005, 0.02), rel=0.45)
    for one, level in zip(drawn, levels, strict=True):
        assert np.mean(innovations_filter(one.response, level)(one.signal) ** 2) == pytest.approx(1.0, abs=0.08)


@pytest.mark.parametrize("output", ["speed", "position"])
def test_a_whitened_residual_is_white_at_every_frequency(output: str) -> None:
    """The periodogram over the noise is exponentially distributed: the null of every later test."""
    drawn = residuals(output, 0.005, 0.02, 0.99, seed=4)
    for one, level in zip(drawn, fit_levels(drawn), strict=True):
        white = innovations_filter(one.response, level)(one.signal)
        power = np.abs(np.fft.rfft(white)[8:-1]) ** 2 / len(white)
        assert kstest(power, "expon").pvalue > 1e-3


def test_the_believed_white_noise_of_an_angle_is_far_off() -> None:
    """Why innovations: taken as it is, the same residual has all its energy in its lowest frequencies."""
    one = residuals("position", 0.005)[0]
    power = np.abs(np.fft.rfft(one.signal)[8:-1]) ** 2
    assert power[:50].sum() > 0.5 * power.sum()


def test_what_columns_have_taken_does_not_make_the_noise_look_smaller() -> None:
    h = np.arange(SAMPLES) * H
    columns = np.stack([np.cos(2 * np.pi * f * h + p) for f in np.arange(0.25, 60.0, 0.5) for p in (0.0, 1.6)])
    plain = residuals("position", 0.005, seed=6)
    basis = np.linalg.qr(columns.T)[0].T
    taken = [Residual(one.signal - basis.T @ (basis @ one.signal), one.response, columns) for one in plain]
    naive = [Residual(one.signal, one.response) for one in taken]
    wrong, right = (np.sqrt(fit_levels(one)[0].torque) for one in (naive, taken))
    assert right == pytest.approx(0.005, rel=0.2)
    assert abs(wrong - 0.005) > 2 * abs(right - 0.005)


def test_the_quantum_of_an_encoder_is_the_least_noise() -> None:
    quiet = [
        Residual(0.01 * one.signal, one.response, least=NOISE["position"] ** 2) for one in residuals("position", 0.0)
    ]
    assert fit_levels(quiet)[0].output == NOISE["position"] ** 2


def test_the_torque_cannot_be_noisier_than_it_is_recorded() -> None:
    t = np.arange(SAMPLES) * H
    smooth = np.sin(20 * t)
    assert torque_floor(smooth) < 1e-12
    noisy = smooth + 0.03 * np.random.default_rng(1).standard_normal(SAMPLES)
    assert np.sqrt(torque_floor(noisy)) == pytest.approx(0.03, rel=0.1)
    by_speed = torque_floor(noisy, np.random.default_rng(2).standard_normal(SAMPLES))
    assert np.sqrt(by_speed) == pytest.approx(0.03, rel=0.1), "a speed that it does not follow takes nothing of it"
    bounded = [replace(one, most_torque=1e-6) for one in residuals("speed", 0.03)]
    assert fit_levels(bounded)[0].torque <= 1e-6


@pytest.mark.parametrize("memory", [0.6, 0.8, 0.9])
@pytest.mark.parametrize("output", ["speed", "position"])
def test_what_a_bounded_noise_may_not_explain_is_left_to_the_others(output: str, memory: float) -> None:
    """A red noise may look nearly white: where the recorded torque holds no white one, it is red all the same."""
    for one in residuals(output, 0.0, 0.02, memory):
        (found,) = fit_levels([replace(one, most_torque=0.004**2)])
        assert 0.0 < found.torque + found.red < 0.03**2
        assert found.red > found.torque
        assert is_explained(one, found)


def test_every_residual_has_its_own_bound_of_the_torques_noise() -> None:
    quiet, loud = residuals("speed", 0.01)[0], residuals("speed", 0.03)[1]
    first, second = fit_levels([replace(quiet, most_torque=0.01**2), loud])
    assert np.sqrt(first.torque) == pytest.approx(0.01)
    assert np.sqrt(second.torque) == pytest.approx(0.03, rel=0.15)


@pytest.mark.parametrize("samples", [200, 4000])
@pytest.mark.parametrize("error", [0.0, 0.005])
def test_a_torque_that_a_controller_makes_of_the_sensors_noise_is_no_error_of_it(samples: int, error: float) -> None:
    """Half of the speed's noise, a sample late, is 0.01 Nm. What bounds the error may not be below it by chance."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        speed = 5 * np.sin(20 * np.arange(samples) * H) + 0.02 * rng.standard_normal(samples)
        torque = -0.5 * np.roll(speed, 1) + error * rng.standard_normal(samples)
        found = np.sqrt(torque_floor(torque, speed))
        assert np.sqrt(torque_floor(torque)) > 0.6 * np.hypot(error, 0.01)
        assert 0.9 * error <= found < 2.0 * error + 0.002


def test_what_cannot_be_told_is_taken_as_it_is_on_average() -> None:
    """A quiet torque is bounded by what would show; a loud one keeps its level."""
    for torque, factor in ((0.0, 0.0), (0.03, 0.03)):
        drawn = residuals("speed", torque)
        (level, *_) = expected_levels(drawn, fit_levels(drawn))
        assert np.sqrt(level.torque) == pytest.approx(factor, abs=0.006)
        assert level.torque > 0.0


def test_a_short_record_leaves_the_memory_of_the_noise_open() -> None:
    """The corner of a red noise on the torque is told by a long record only; its neighbours count with their share."""
    drawn = residuals("speed", 0.005, 0.02, 0.99)
    short = [replace(one, signal=one.signal[:800]) for one in drawn[:1]]
    spread = []
    for seen in (drawn, short):
        found = likely_levels(seen, fit_levels(seen))
        assert sum(share for share, _ in found) == pytest.approx(1.0)
        assert max(share for share, _ in found) < 1.0
        best = max(found, key=lambda one: one[0])[1]
        assert 1 / SETTINGS.corner_step < best[0].corner / fit_levels(seen)[0].corner < SETTINGS.corner_step
        red = [one[0].corner for _, one in found if one[0].red > 0.0]
        spread.append(max(red) / min(red))
    assert spread[0] < spread[1]


def test_noises_that_look_alike_count_no_more_often_than_they_can_be_told_apart() -> None:
    """Half a second shows of a memory of one second and of ten only that it is long: however many such corners are
    tried, each weighs less than its likelihood says, and together they leave the level where it is."""
    (one,) = residuals("speed", 0.005, 0.02, 0.99)[:1]
    short = [replace(one, signal=one.signal[:1500])]
    levels = fit_levels(short)
    found = choices(short, whitened(short, levels), replace(SETTINGS, corner_step=1.5))
    red = [choice for choice in found if choice.levels[0].red > 0.0]
    assert red[0].shape < 0.5 * max(choice.shape for choice in red)
    coarse, fine = (
        sum(share * one[0].red / one[0].corner for share, one in likely_levels(short, levels, settings=settings))
        for settings in (replace(SETTINGS, fine_step=1.5), replace(SETTINGS, fine_step=1.2))
    )
    assert coarse == pytest.approx(fine, rel=0.1)


def test_levels_count_from_the_same_whitened_residual() -> None:
    """Whitening a residual once for all means over its levels changes nothing."""
    drawn = residuals("speed", 0.005, 0.02, 0.99)
    levels = fit_levels(drawn)
    seen = whitened(drawn, levels)
    assert likely_levels(drawn, levels, seen) == likely_levels(drawn, levels)
    assert expected_levels(drawn, levels, seen) == expected_levels(drawn, levels)
    for one, level, own in zip(drawn, levels, seen, strict=True):
        assert is_explained(one, level, innovations=own) == is_explained(one, level)


def test_a_residual_of_nothing_has_no_noise() -> None:
    nothing = [Residual(np.zeros(SAMPLES), joint("speed"))]
    (level,) = fit_levels(nothing)
    assert likely_levels(nothing, [level]) == [(1.0, (level,))]
    assert max(level.output, level.torque, level.red) < 1e-200


def test_the_filter_of_an_output_noise_is_its_inverse() -> None:
    signal = np.arange(5.0)
    assert innovations_filter(joint("speed"), NoiseLevels(4.0))(signal) == pytest.approx(signal / 2.0)


def test_the_transposed_filter_is_the_adjoint() -> None:
    rng = np.random.default_rng(3)
    whiten = innovations_filter(joint("position"), NoiseLevels(1e-10, 1e-5, 1e-4, 10.0))
    a, b = rng.standard_normal((2, 200))
    assert a @ whiten(b) == pytest.approx(whiten.transposed(a) @ b, rel=1e-6)


def test_levels_that_explain_a_periodogram() -> None:
    rng = np.random.default_rng(0)
    bases = np.stack([np.ones(5000), np.linspace(100.0, 0.1, 5000)])
    power = (np.array([2.0, 0.3]) @ bases) * rng.exponential(size=5000)
    of = np.zeros(5000, dtype=np.intp)
    shapes = _Shapes(bases[0], bases[1:], of, _apart(of, 1))
    (output,), (torque,), _ = _likeliest(power, shapes, np.ones(5000), np.zeros(5000))
    assert (output, torque) == pytest.approx((2.0, 0.3), rel=0.1)


@pytest.mark.parametrize("output", ["speed", "position"])
def test_the_spread_of_an_estimate_is_that_of_repeated_draws(output: str) -> None:
    """J R J' for torque noise that lasts, against what the same columns find in drawn residuals."""
    rng, t = np.random.default_rng(8), np.arange(SAMPLES) * H
    columns = np.stack([np.sin(6 * t), np.sign(np.sin(4 * t)), t])
    levels = NoiseLevels(NOISE[output] ** 2, 0.02**2, 0.01**2, -np.log(0.99) / H)
    told = SeenDerivatives.of(columns, joint(output)).information(levels)
    drawn = np.stack([columns @ residual(output, rng, 0.02, 0.01, 0.99) for _ in range(60)])
    assert np.sqrt(np.diag(told)) == pytest.approx(np.sqrt(np.mean(drawn**2, axis=0)), rel=0.3)


def test_a_misfit_is_not_explained_by_noise() -> None:
    drawn = residuals("speed", 0.005)
    assert all(is_explained(one, level) for one, level in zip(drawn, fit_levels(drawn), strict=True))
    wave = 0.02 * np.sin(2 * np.pi * 150.0 * np.arange(SAMPLES) * H)
    wrong = [replace(one, signal=one.signal + wave) for one in drawn]
    assert not any(is_explained(one, level) for one, level in zip(wrong, fit_levels(wrong), strict=True))


@pytest.mark.parametrize("count", [20, 41, 60])
def test_columns_that_take_nearly_all_of_a_short_piece(count: int) -> None:
    """As those of reversals do where a motion rests in noise."""
    rng, found = np.random.default_rng(4), []
    for _ in range(20):
        columns = rng.standard_normal((count, 50))
        noise = NOISE["speed"] * rng.standard_normal(50)
        (one,) = fit_levels([Residual(noise, joint("speed"), columns)])
        found.append(np.sqrt(one.output))
    assert np.median(found) == pytest.approx(NOISE["speed"], rel=0.2)


@pytest.mark.parametrize("output", ["speed", "position"])
def test_the_response_by_modes_is_that_of_every_frequency(output: str) -> None:
    response, omega = joint(output), np.geomspace(1e-3, np.pi, 50)
    z = np.exp(1j * omega)
    exact = [np.linalg.solve(one * np.eye(len(response.b)) - response.A, response.b)[response.row] for one in z]
    assert response.squared(omega) == pytest.approx(np.abs(exact) ** 2, rel=1e-6)


def test_the_response_of_modes_that_coincide() -> None:
    """An inertia without friction: a double integrator."""
    response = TorqueResponse(np.array([[1.0, H], [0.0, 1.0]]), np.array([H**2 / 2 / J, H / J]), 0, H)
    omega = np.array([1e-3, 0.1, 1.0])
    exact = (H**2 / 2 / J * np.abs(np.exp(1j * omega) + 1.0) / np.abs(np.exp(1j * omega) - 1.0) ** 2) ** 2
    assert response.squared(omega) == pytest.approx(exact, rel=1e-6)


def test_a_residual_that_is_zero_throughout_tells_of_no_noise() -> None:
    """A piece in which the motor rests where its simulation does: beside it the others have the levels of their own."""
    shown = residuals("speed", 0.03)
    silent = replace(shown[0], signal=np.zeros(SAMPLES))
    found = fit_levels([silent, *shown, silent])
    assert found[1:-1] == fit_levels(shown)
    assert (found[0].torque, found[0].red) == (found[1].torque, found[1].red)
    near = fit_levels([silent, *shown], near=found[:-1])
    assert near[1].torque == pytest.approx(found[1].torque, rel=0.05)


def test_an_octave_of_one_of_many_residuals_may_stand_out_by_chance() -> None:
    """Its energy has a chi-squared distribution, of which the lowest octave has few degrees of freedom."""
    one = residuals("speed", 0.0)[0]
    (level,) = fit_levels([one])
    loud = np.sqrt(level.output) * np.sin(2 * np.pi * 3.5 * np.arange(SAMPLES) / SAMPLES)

    def passes(size: float, among: int) -> bool:
        return is_explained(replace(one, signal=one.signal + size * loud), level, among=among)

    sizes = np.geomspace(0.1, 30.0, 120).tolist()
    alone, among_many = (max(size for size in sizes if passes(size, among)) for among in (1, 100))
    assert alone < among_many < 2.0 * alone


def test_pieces_of_a_record_are_judged_together() -> None:
    """Errors of the torque may be larger in one piece than in the others; what is in all of them is no chance."""
    pieces = [residuals("speed", 0.0, seed=seed)[0] for seed in range(12)]
    levels = fit_levels(pieces)
    loud = np.sqrt(levels[0].output) * np.sin(2 * np.pi * 3.5 * np.arange(SAMPLES) / SAMPLES)

    def louder(size: float, at: range) -> list[Residual]:
        return [replace(one, signal=one.signal + size * (k in at) * loud) for k, one in enumerate(pieces)]

    def alone(size: float) -> bool:
        return is_explained(louder(size, range(1))[0], levels[0], tolerance=1.5, among=12)

    least = min(size for size in np.geomspace(0.01, 1.0, 60).tolist() if not alone(size))
    assert are_explained(louder(1.1 * least, range(1)), levels, tolerance=1.5)
    assert alone(0.9 * least)
    assert not are_explained(louder(0.9 * least, range(12)), levels, tolerance=1.5)


@pytest.mark.parametrize("common", [0, 1, 2])
def test_levels_of_residuals_apart_are_those_of_all_lines_at_once(common: int) -> None:
    rng = np.random.default_rng(common)
    for _ in range(50):
        n = int(rng.integers(2, 9))
        of = np.sort(np.concatenate([np.arange(n), rng.integers(0, n, 12 * n)]))
        own = (of == np.arange(n)[:, None]) * rng.exponential(1.0, len(of))
        columns = np.vstack([own, rng.exponential(1.0, (common, len(of)))])
        columns[0] *= rng.random() < 0.9  # one that shows nothing of its own
        aim = columns.T @ rng.normal(0.3, 1.0, n + common) + rng.normal(0.0, 1.0, len(of))
        expected, _ = nnls(columns.T, aim)
        np.testing.assert_allclose(
            _least_squares(columns[:n].sum(axis=0), columns[n:], aim, _apart(of, n)), expected, atol=1e-9
        )
