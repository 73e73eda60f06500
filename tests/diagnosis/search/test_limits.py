"""Detection limits: an effect of that size just passes the tests of a cause, and what has no column has no limit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import isinf

import numpy as np
import pytest
from diagnosis.search.test_coloured import slow_errors, with_effect
from scipy.stats import f as fisher
from support.small_bench import begun, records, searched

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.colour import ColouredNoise
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import extended
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression, blocked
from robotid.diagnosis.search.least_scored import GREATEST
from robotid.diagnosis.search.limits import detection_limits, least_energy, least_size, typical_shapes
from robotid.diagnosis.search.rounds import as_result
from robotid.diagnosis.search.state import SearchResult
from robotid.estimate.noise.whitening import NoiseLevels, innovations_filter

CRITERIA = Criteria(skip=("record_change",))


@cache
def clean() -> SearchResult:
    """Of the small bench with nothing hidden."""
    return searched(records({}), CRITERIA)


@cache
def beside_slow_errors() -> SearchResult:
    """The same beside slow errors of the torque."""
    return searched(slow_errors(records({}), 1), CRITERIA)


def without_torque_noise() -> ColouredNoise:
    """The noise of the small bench, as if all of it were the sensor's."""
    noise = clean().noise
    assert noise is not None
    plain = [innovations_filter(one.response, NoiseLevels(1e-4)) for one in noise.residuals]
    return replace(noise, segments=tuple(Segment(one.record, f) for one, f in zip(noise.segments, plain, strict=True)))


def limits(found: SearchResult, criteria: Criteria = CRITERIA) -> dict[str, float]:
    return {one.effect: one.size for one in detection_limits(found, criteria)}


def regression(seed: int, drift: float) -> BlockedRegression:
    """Of noise, alike in all blocks or growing from block to block, on two regressors."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((2, 4000))
    noise = rng.standard_normal(4000) * (1.0 + drift * np.arange(4000) / 4000)
    return blocked(columns, noise, 100)


def with_last(blocks: BlockedRegression, size: float) -> BlockedRegression:
    """The regression with its last amplitude at a size, whatever it was."""
    change = size - blocks.estimate()[-1]
    return replace(blocks, moment=blocks.moment + change * blocks.information[:, :, -1])


@pytest.mark.parametrize("drift", [0.0, 3.0])
@pytest.mark.parametrize("level", [1e-2, 1e-5])
def test_an_amplitude_of_the_least_size_is_significant_by_just_the_level(drift: float, level: float) -> None:
    blocks = regression(1, drift)
    k = blocks.moment.shape[1] - 1
    telling = blocks.telling_blocks([k])
    size = least_size(blocks, 1, level)
    assert with_last(blocks, size).significance([k]) == pytest.approx(level, rel=1e-6)
    assert with_last(blocks, 1.1 * size).significance([k]) < level < with_last(blocks, 0.9 * size).significance([k])
    assert telling > 30


def test_an_amplitude_that_one_block_tells_of_has_no_least_size() -> None:
    columns = np.zeros((1, 4000))
    columns[0, :90] = 1.0
    assert isinf(least_size(blocked(columns, np.random.default_rng(2).standard_normal(4000), 100), 1, 1e-3))


def test_the_least_energy_is_that_of_the_level_among_all_tries() -> None:
    energy = least_energy(2, 1.5, CRITERIA, tries=200, samples=8000)
    assert 200 * fisher.sf(energy / 2 / 1.5, 2, 8000) == pytest.approx(CRITERIA.significance)


def test_every_effect_of_the_catalogue_that_the_model_lacks_has_one_limit() -> None:
    names = [one.effect for one in detection_limits(clean(), CRITERIA)]
    seen = clean().rounds[-1]
    assert names == sorted({one.name for one in seen.candidates})
    lacking = [one.name for one in typical_shapes(seen, present=("motor.stribeck",))]
    assert set(names) - set(lacking) == {"motor.stribeck"}


def test_what_the_fitted_parameters_do_as_well_is_invisible() -> None:
    """The gain of the torque is that of all parameters together."""
    found = limits(clean())
    assert isinf(found["torque.torque_gain"])
    assert not isinf(found["motor.stribeck"])


def test_a_larger_least_improvement_makes_the_limits_larger_in_proportion_but_for_the_noise_that_they_make() -> None:
    """Until it is named an effect makes noise, by which its limit is up to GREATEST times as large; a still larger one
    no longer looks like noise."""
    once, twice = (limits(clean(), replace(CRITERIA, min_improvement_sigma=size)) for size in (2.0, 4.0))
    ratios = [twice[name] / once[name] for name in once if not isinf(twice[name])]
    assert len(ratios) > 3
    assert min(ratios) > 2.0 / GREATEST - 1e-9
    assert max(ratios) < 2.0 * GREATEST + 1e-9
    assert np.median(ratios) == pytest.approx(2.0)


def test_a_search_that_ran_out_of_time_has_limits_too() -> None:
    state = begun(records({}), CRITERIA).scored(CRITERIA)
    assert set(limits(as_result(state))) == set(limits(clean()))


@pytest.mark.parametrize("symbol", ["asymmetric_coulomb.dFc", "asymmetric_viscous.dFv", "quadratic_friction.Fq"])
def test_slow_errors_of_the_torque_make_less_of_an_effect_than_its_limit(symbol: str) -> None:
    made = [with_effect(slow_errors(records({}), seed), {f"motor.{symbol}": 1e-3}) for seed in range(4)]
    scatter = np.sqrt(np.mean([one.parameters[f"motor.{symbol}"] ** 2 for one in made]))
    limit = limits(beside_slow_errors())[f"motor.{symbol.partition('.')[0]}"]
    assert 2.0 * scatter < limit < 20.0 * scatter


def test_errors_of_the_torque_that_pass_along_the_motion_make_limits_larger() -> None:
    """Where a motor rests and reverses, an error shows otherwise than through a joint that slips all the time."""
    found = beside_slow_errors()
    along, slipping = limits(found), limits(replace(found, noise=None))
    assert all(along[name] >= slipping[name] for name in along)
    assert along["motor.asymmetric_coulomb"] > 1.3 * slipping["motor.asymmetric_coulomb"]


@pytest.mark.parametrize("name", ["torque.torque_lag.T", "motor.asymmetric_coulomb.dFc"])
def test_a_limit_is_a_size_that_a_fit_tells_from_none_though_slow_errors_weigh_as_much_there(name: str) -> None:
    scatter = np.sqrt(np.mean([_by_a_fit(name, seed) ** 2 for seed in range(6)]))
    assert 2.0 * scatter < limits(beside_slow_errors())[name.rpartition(".")[0]] < 20.0 * scatter


def _by_a_fit(name: str, seed: int) -> float:
    """What a fit takes slow errors of the torque for."""
    state = begun(slow_errors(records({}), seed))
    structure, start = extended(state.first, name.rpartition(".")[0], {name: 1e-4})
    plain = replace(state.data, fitted=tuple(Segment(one.record, UNIT_WHITENING) for one in state.data.fitted))
    return refit(structure, [start], plain, state.first.trajectories).parameters[name]


def test_noise_of_the_output_alone_makes_nothing_along_the_motion() -> None:
    quiet = replace(clean(), noise=None)
    assert limits(replace(quiet, noise=without_torque_noise())) == limits(quiet)


@pytest.mark.parametrize(("times", "named"), [(1.0 / 3.0, False), (2.0, True)])
def test_a_third_of_a_limit_is_not_named_and_twice_a_limit_is(times: float, named: bool) -> None:
    size = times * limits(clean())["motor.quadratic_friction"]
    found = searched(records({"motor.quadratic_friction.Fq": size}), CRITERIA)
    assert any("motor.quadratic_friction" in cause.twins for cause in found.causes) == named
