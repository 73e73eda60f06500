"""A gain counts where it is beyond its own spread over blocks of time that served for no fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.plain_models import SAMPLES, plain_data, plain_model, plain_segment

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refitted_model import SegmentFit
from robotid.diagnosis.scoring.blocked_regression import Gain, gain_of
from robotid.diagnosis.search.acceptance import gains_by_chance
from robotid.diagnosis.search.carry_over import gain_by_blocks, proven, together
from robotid.diagnosis.search.step import Step
from robotid.model.array import Array

LEVEL = 1e-3


def leaving(residual: Array) -> SegmentFit:
    return replace(plain_segment(1.0), residual=residual, energy=float(residual @ residual))


def noise(seed: int, size: float = 1.0) -> Array:
    return size * np.random.default_rng(seed).standard_normal(SAMPLES)


def test_what_helps_everywhere_is_a_gain() -> None:
    assert proven(gain_by_blocks((leaving(noise(1, 1.5)),), (leaving(noise(2)),)))


def test_what_helps_by_chance_is_none() -> None:
    gains = [gain_by_blocks((leaving(noise(2 * k)),), (leaving(noise(2 * k + 1)),)) for k in range(100)]
    assert 30 < sum(gain.total > 0.0 for gain in gains) < 70  # above zero as often as not
    assert sum(proven(gain) for gain in gains) <= 12  # five in a hundred, and chance


def test_what_helps_once_is_none() -> None:
    wrong = noise(1)
    wrong[100:140] += 10.0
    gain = gain_by_blocks((leaving(wrong),), (leaving(noise(2)),))
    assert gain.total > 1000.0
    assert not proven(gain)


def test_nothing_gained_is_no_gain() -> None:
    assert gain_of(np.zeros(20)).p_value == 1.0
    assert gain_of(np.zeros(20)).by_its_mean == 1.0


def test_the_mean_tells_little_where_few_blocks_hold_most_of_a_gain() -> None:
    small = 1.0 + 0.1 * np.arange(20.0)
    throughout, mostly_once = gain_of(small), gain_of(np.append(small, 1000.0))
    assert max(throughout.p_value, throughout.by_its_mean) < 1e-5
    assert mostly_once.p_value < 1e-5
    assert mostly_once.by_its_mean > 0.1
    assert gain_of(np.append(np.zeros(20), 1.0)).by_its_mean == 1.0
    chance = [gain_of(np.random.default_rng(seed).standard_normal(20)).by_its_mean for seed in range(400)]
    assert 0.03 < np.mean(np.array(chance) < 0.05) < 0.08


def test_the_objection_names_the_records_or_what_was_left_out() -> None:
    lucky = plain_model(1000.0), plain_model(900.0)
    before, after = (replace(m, validation=(leaving(noise(s)),)) for m, s in zip(lucky, (4, 5), strict=True))
    after = replace(after, validation=(replace(after.validation[0], fit_percent=99.0),))
    step = Step(before, before, after, plain_data())
    assert step.energy_a_sample > 0.0
    assert "within its scatter" in str(gains_by_chance(step, Criteria()))
    alone = Step(*(plain_model(e) for e in (1000.0, 1000.0, 900.0)), plain_data(validation=False))
    assert gains_by_chance(alone, Criteria()) is None
    alone.__dict__["left_out"] = gain_of(np.array([1.0, -1.0, 2.0, -2.0, 0.5]))
    assert "left out of its fit" in str(gains_by_chance(alone, Criteria()))


def test_where_only_a_moment_shows_a_cause_the_records_must_ask_for_it_by_themselves() -> None:
    wrong = noise(1)
    wrong[100:110] += 10.0
    before, after = (replace(plain_model(1000.0), validation=(leaving(one),)) for one in (wrong, noise(2)))
    step = Step(
        before, before, replace(after, validation=(replace(after.validation[0], fit_percent=99.0),)), plain_data()
    )
    for p, stands in ((1e-5, True), (0.05, False)):
        step.__dict__["confirmation"] = p
        assert (gains_by_chance(step, Criteria()) is None) == stands


def a_gain() -> Gain:
    return gain_of(1.0 + 0.1 * noise(1)[:20])


@pytest.mark.parametrize(("fitted", "together_enough"), [(5e-3, True), (0.04, True), (0.06, False)])
def test_a_gain_counts_with_the_records_of_the_fit_that_hint_at_it(fitted: float, *, together_enough: bool) -> None:
    assert (together(fitted, a_gain()) < LEVEL) is together_enough


def test_a_gain_that_is_the_best_of_many_counts_less() -> None:
    assert together(5e-3, a_gain(), tries=10) > together(5e-3, a_gain())
    assert together(5e-3, a_gain(), tries=10**6) == 5e-3


def test_a_gain_within_its_spread_and_a_loss_count_nothing() -> None:
    assert together(5e-3, gain_of(noise(2)[:20])) == 5e-3
    assert together(5e-3, gain_of(-a_gain().blocks)) == 5e-3


def test_without_a_gain_the_records_of_the_fit_decide() -> None:
    assert together(5e-3, None) == 5e-3


def test_a_gain_takes_nothing_from_what_is_certain() -> None:
    assert together(0.0, a_gain()) == 0.0
