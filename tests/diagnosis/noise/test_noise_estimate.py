"""The noise that a diagnosis reckons with: that of the sensors where it is reached, torque errors besides where not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.hidden_records import SPEED_NOISE, hidden

from robotid.diagnosis.noise.noise_estimate import Explained, NoiseEstimate, TorqueErrors, estimate_noise
from robotid.estimate.fitted_model import SimulatedSegment


@cache
def segments(effect: str, value: float) -> tuple[SimulatedSegment, ...]:
    symbol = {"constant_torque": "tau0", "quadratic_friction": "Fq"}[effect]
    found = [hidden(effect, {symbol: value}, number=number) for number in (1, 2)]
    return tuple(segment for one in found for segment in one.simulated.segments("speed"))


CLEAN = ("constant_torque", 0.0)
WRONG = ("quadratic_friction", 2e-4)


def estimated(left: tuple[SimulatedSegment, ...], *, torque_errors: TorqueErrors) -> NoiseEstimate:
    """The noise where candidates and curves leave this of a misfit."""
    found = leaving(segments(*WRONG), left)
    return estimate_noise(segments(*WRONG), found, lambda: found, "speed", torque_errors=torque_errors)


def leaving(before: tuple[SimulatedSegment, ...], left: tuple[SimulatedSegment, ...]) -> Explained:
    """Columns that leave this of residuals."""
    columns = (one.residual - after.residual for one, after in zip(before, left, strict=True))
    return Explained(tuple(one[None] if one.any() else one[None][:0] for one in columns), left)


def energy_a_sample(estimate: NoiseEstimate, left: tuple[SimulatedSegment, ...]) -> float:
    energy = sum(one.energy(part.residual) for one, part in zip(estimate.segments, left, strict=True))
    return energy / sum(len(part.residual) for part in left)


@pytest.mark.parametrize("kind", [None, "white", "coloured"])
def test_what_is_explained_down_to_the_noise_has_the_noise_of_the_sensors(kind: TorqueErrors) -> None:
    found = estimated(segments(*CLEAN), torque_errors=kind)
    assert found.reached
    for segment in found.segments:
        assert np.sqrt(segment.whitening.levels.output) == pytest.approx(SPEED_NOISE, rel=0.1)
    assert energy_a_sample(found, segments(*CLEAN)) == pytest.approx(1.0, rel=0.2)


@pytest.mark.parametrize("kind", ["white", "coloured"])
def test_what_nothing_explains_counts_as_torque_errors_only_where_that_is_asked(kind: TorqueErrors) -> None:
    left = segments(*WRONG)
    sensors, errors = (estimated(left, torque_errors=asked) for asked in (None, kind))
    assert not sensors.reached
    assert not errors.reached
    assert energy_a_sample(sensors, left) > 10.0
    found, least = (one.segments[0].whitening.levels for one in (errors, sensors))
    assert found.torque + found.red > 2.0 * least.torque
    assert energy_a_sample(errors, left) < 0.1 * energy_a_sample(sensors, left)


def test_free_curves_are_only_asked_where_candidates_leave_too_much() -> None:
    asked = list[bool]()

    clean, wrong = segments(*CLEAN), segments(*WRONG)

    def curves() -> Explained:
        asked.append(True)
        return leaving(wrong, clean)

    assert estimate_noise(wrong, leaving(wrong, clean), curves, "speed", torque_errors=None).reached
    assert asked == []
    assert estimate_noise(wrong, leaving(wrong, wrong), curves, "speed", torque_errors=None).reached
    assert asked == [True]


def test_a_segment_at_rest_does_not_have_much_less_noise_than_the_others() -> None:
    first, second = segments(*CLEAN)
    still = replace(second, residual=1e-3 * second.residual)
    seen = (first, first, still)
    nothing = leaving(seen, seen)
    found = estimate_noise(seen, nothing, lambda: nothing, "speed", torque_errors=None)
    levels = [np.sqrt(segment.whitening.levels.output) for segment in found.segments]
    assert levels[2] == pytest.approx(0.25 * levels[0], rel=0.05)


@pytest.mark.parametrize("columns", [1, 700])
def test_errors_of_the_torque_count_where_few_of_many_short_pieces_show_them(columns: int) -> None:
    """Of a short piece the columns take most of what is slow: most pieces show nothing of it, and tell nothing."""
    rng, (loud, _) = np.random.default_rng(2), segments(*WRONG)
    first, last = (replace(loud, residual=SPEED_NOISE * rng.standard_normal(len(loud.residual))) for _ in range(2))
    seen = (first, loud, last)
    nothing = Explained((np.zeros((columns, 1)),) * len(seen), seen)
    sensors, errors = (
        estimate_noise(seen, nothing, lambda: nothing, "speed", torque_errors=asked) for asked in (None, "white")
    )
    share = energy_a_sample(errors, seen) / energy_a_sample(sensors, seen)
    assert share < 0.1 if columns > 1 else share > 0.9


def test_segments_in_which_all_rests_do_not_take_the_noise_from_the_others() -> None:
    moving, _ = segments(*CLEAN)
    still = replace(moving, residual=np.zeros(len(moving.residual)))
    seen = (still, moving, still, still)
    nothing = leaving(seen, seen)
    found = estimate_noise(seen, nothing, lambda: nothing, "speed", torque_errors=None)
    levels = [np.sqrt(segment.whitening.levels.output) for segment in found.segments]
    assert levels[1] == pytest.approx(SPEED_NOISE, rel=0.1)
    assert levels[0] == pytest.approx(0.25 * levels[1], rel=0.05)
