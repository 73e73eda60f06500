"""Checks of the noise room's constants."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import scipy

from robotid.diagnosis.noise import colour, quantisation
from robotid.diagnosis.noise import drawn as drawn_noise
from robotid.diagnosis.noise import spectrum as spectra
from robotid.diagnosis.noise.noise_estimate import is_reached, output_variances, sufficient_variance
from robotid.diagnosis.noise.noise_floor import (
    Noise,
    _agreed_torque_variance,
    _room_for_torque,
    spectrum_levels,
)
from robotid.diagnosis.noise.settings import NOISE
from robotid.diagnosis.noise.spectrum import Spectrum, steady_spectrum, whittle
from robotid.estimate.noise.levels import KINSHIP
from robotid.estimate.noise.whitening import NoiseLevels
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory
from support.plain_models import SAMPLES, plain_segment
from support.tuning import sees

LINES = 1025
FALLING = 100.0 / (1.0 + np.arange(LINES)) ** 2  # a torque's response


def steps_to_fit(power: Array, shapes: Array) -> int:
    """How many steps of Fisher scoring a fit takes."""
    count, solve = 0, spectra.nnls

    def counted(*arguments: Array) -> tuple[Array, float]:
        nonlocal count
        count += 1
        return solve(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spectra, "nnls", counted)
        whittle(power, shapes)
    return count


def drawn(seed: int) -> Array:
    """A periodogram of both noises: each line exponential."""
    return (1.0 + 30.0 * FALLING) * np.random.default_rng(seed).exponential(size=LINES)


def evidence(torque: float) -> tuple[Spectrum, float]:
    """A spectrum as such a torque noise makes it on average, and twice the log-likelihood that it gains."""
    seen = Spectrum(1.0 + torque * FALLING, FALLING)
    both, alone = (whittle(seen.power[4:], shapes)[1] for shapes in (seen.shapes[:, 4:], seen.shapes[:1, 4:]))
    return seen, alone - both


def with_evidence(wanted: float) -> Spectrum:
    torque = scipy.optimize.brentq(lambda t: evidence(t)[1] - wanted, 1e-3, 1e3)
    return evidence(torque)[0]


@sees(NOISE, "max_fisher_steps")
def check_a_fit_that_never_settles_ends() -> None:
    with pytest.MonkeyPatch.context() as patch:
        levels = iter(range(1, 1000))
        patch.setattr(spectra, "nnls", lambda *_: (np.array([1.0, float(next(levels))]), 0.0))
        whittle(np.ones(8), np.stack([np.ones(8), np.linspace(1.0, 2.0, 8)]))
        assert next(levels) - 1 == 20


@sees(NOISE, "settled_change")
def check_a_fit_ends_when_its_levels_change_by_a_millionth() -> None:
    def ends_at(change: float) -> bool:
        values = iter([1.0, 1.0 + change, 2.0, 3.0, 4.0])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(spectra, "nnls", lambda *_: (np.array([next(values), 0.0]), 0.0))
            try:
                whittle(np.ones(8), np.stack([np.ones(8), np.linspace(1.0, 2.0, 8)]))
            except StopIteration:
                return False
        return next(values) == 2.0

    assert ends_at(0.9e-6)
    assert not ends_at(1.2e-6)


@sees(NOISE, "band_surprise")
def check_four_standard_deviations_of_a_band_pass_for_chance() -> None:
    def explained(deviations: float) -> bool:
        power = np.ones(LINES)
        power[512:1025] += deviations * np.sqrt(KINSHIP / 513)
        return Spectrum(power, FALLING).explained_by(np.ones(LINES), [slice(512, 1025)])

    assert explained(3.9)
    assert not explained(4.1)


@sees(NOISE, "torque_evidence")
def check_a_torque_noise_needs_evidence() -> None:
    assert spectrum_levels(with_evidence(9.0)).torque == 0.0
    assert spectrum_levels(with_evidence(11.0)).torque > 0.0


@sees(NOISE, "torque_hint")
def check_records_that_agree_on_a_torque_noise_need_less() -> None:
    # two of them have twice the evidence of one
    assert _agreed_torque_variance([with_evidence(1.8)] * 2) == 0.0
    assert _agreed_torque_variance([with_evidence(2.2)] * 2) > 0.0


@sees(NOISE, "record_parts")
def check_a_steady_spectrum_is_that_of_an_eighth_of_the_record() -> None:
    n = 4096
    wave = np.sin(2 * np.pi * 64 / n * np.arange(n))
    seen = steady_spectrum(Spectrum(np.ones(n // 2 + 1), np.ones(n // 2 + 1)), wave)
    # the peak of a wave grows with the length of the window; Hann's taper takes a third, the median adds as much
    assert seen.power.max() == pytest.approx(n / 8 / 4, rel=0.15)


@sees(NOISE, "min_band_lines")
def check_a_narrow_band_does_not_bound_a_level() -> None:
    def room(first: int) -> float:
        power = np.full(LINES, 10.0)
        power[first : 2 * first] = 2.0
        return _room_for_torque(Spectrum(power, np.ones(LINES)), 1.0, 5.0)

    assert room(32) == pytest.approx(1.0)
    assert room(16) == pytest.approx(5.0)


@sees(NOISE, "hidden_share")
def check_output_noise_may_hide_below_a_tenth_of_the_quietest_band() -> None:
    seen = Spectrum(FALLING.copy(), FALLING)
    assert spectrum_levels(seen).output == pytest.approx(0.1 * FALLING[512:].mean(), rel=0.2)


@sees(NOISE, "encoder_turns")
def check_an_encoder_is_turned_by_eight_fractions_of_its_quantum() -> None:
    turned, error = list[float](), quantisation.rounding_error
    angle = np.rint(0.3 * np.arange(64.0))
    still = np.zeros(64)
    record = Record("r", "estimate", "both", 0.001, still, angle, still, speed_origin="central difference")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quantisation, "rounding_error", lambda *one: turned.append(one[2]) or error(*one))
        quantisation.quantisation_spectrum(record, "speed")
    assert turned == pytest.approx((np.arange(8) + 0.5) / 8)


@sees(NOISE, "encoder_band")
def check_an_encoders_spectrum_is_averaged_over_a_tenth_of_the_frequency() -> None:
    seen = quantisation._smooth(np.where(np.arange(LINES) == 500, 51.0, 0.0))
    assert seen[500] == pytest.approx(1.0)
    assert np.count_nonzero(seen) == pytest.approx(50, abs=2)


@sees(NOISE, "rest_share")
def check_a_record_at_rest_has_a_quarter_of_the_typical_noise() -> None:
    noise = [Noise(level, 0.0, level, True) for level in (1.0, 1.0, 0.01)]
    assert output_variances(noise) == pytest.approx((1.0, 1.0, 0.25**2))


@sees(NOISE, "unexplained_energy")
def check_twice_the_noise_is_unexplained() -> None:
    assert is_reached(1.9, 10.0)
    assert not is_reached(2.1, 10.0)


@sees(NOISE, "linear_share")
def check_linear_columns_may_leave_two_per_cent_of_a_misfit() -> None:
    assert is_reached(0.019 * 500, 500.0)
    assert not is_reached(0.021 * 500, 500.0)


@sees(NOISE, "max_linear_energy")
def check_linear_columns_may_not_leave_twenty_times_the_noise() -> None:
    assert is_reached(19.0, 1e6)
    assert not is_reached(21.0, 1e6)


@sees(NOISE, "variance_resolution")
def check_a_variance_is_found_to_a_tenth() -> None:
    asked = list[float]()

    def excess(torque: float) -> float:
        asked.append(torque)
        return 0.01 / torque

    found = sufficient_variance(excess, 1e-3, 1.0)
    assert found == pytest.approx(0.01, rel=0.1)
    assert len(asked) == 8  # halvings of seven natural units, and the first question


@sees(NOISE, "min_variance_ratio")
def check_a_variance_is_sought_over_twelve_powers_of_ten() -> None:
    assert sufficient_variance(lambda _: 0.0, 0.0, 1.0) == pytest.approx(1e-12, rel=0.2, abs=0.0)


@sees(NOISE, "tolerance")
def check_an_octave_may_hold_two_and_a_half_times_the_noise() -> None:
    asked = list[float]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(colour, "are_explained", lambda *_, tolerance, **__: asked.append(tolerance) or True)
        assert colour.coloured_noise([plain_segment(1.0)], [np.zeros((0, SAMPLES))], "speed").explained
    assert asked == [pytest.approx(1.5)]


@sees(NOISE, "draws")
def check_noise_is_drawn_eight_times() -> None:
    asked = list[Array]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawn_noise, "simulate_under", lambda torques, *_: asked.extend(torques) or [None] * len(torques))
        drawn_noise.drawn_residuals(plain_segment(1.0), NoiseLevels(1.0), "speed")
    assert 6 <= len(asked) <= 12


@sees(NOISE, "failed_windows")
def check_a_drawn_simulation_may_fail_in_ten_windows() -> None:
    asked, segment = list[int](), plain_segment(1.0)

    def simulated(torques: Sequence[Array], *given: int) -> list[Trajectory]:
        asked.append(given[-1])
        return [segment.trajectory for _ in torques]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawn_noise, "simulate_under", simulated)
        drawn_noise.drawn_residuals(segment, NoiseLevels(1.0), "speed")
    assert asked
    assert all(5 <= one <= 20 for one in asked)


@sees(NOISE, "clip")
def check_innovations_beyond_three_deviations_count_as_three() -> None:
    asked = list[float]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            colour,
            "fit_levels_by_record",
            lambda _, __, settings, ___: asked.append(settings.clip) or [NoiseLevels(1.0)],
        )
        colour.coloured_noise([plain_segment(1.0)], [np.zeros((0, SAMPLES))], "speed")
    assert asked == [pytest.approx(3.0)]
