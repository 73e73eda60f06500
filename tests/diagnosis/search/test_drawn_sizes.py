"""The size that errors of the torque give a cause along a motion that reverses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from diagnosis.search.test_coloured import slow_errors
from support.small_bench import STRIBECK, begun, records

from robotid.diagnosis.noise import colour
from robotid.diagnosis.nonparametric.curve_fit import fit_curves
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, carried
from robotid.diagnosis.scoring.scan import scans
from robotid.diagnosis.search.coloured import by_noise, left_by
from robotid.diagnosis.search.drawn_sizes import DrawnSizes, curve_among_draws, curve_p_value
from robotid.model.array import Array
from robotid.signals.record import Record

LEVEL = 1e-3
CHANGE = "record_change.slow.motor.coulomb.Fc"
SEEDS = range(4)


def sizes(made: list[Record], values: Mapping[str, float], effect: str) -> DrawnSizes:
    state = begun(made)
    structure = state.first.structure.extended(effect)
    start = carried(state.first.parameters, structure, values)
    model = refit(structure, [start], state.data, state.first.trajectories)
    found = DrawnSizes.of(model, effect, left_by(model))
    assert found is not None
    return found


def through_a_slipping_joint(one: DrawnSizes) -> float:
    """Standard deviation of the first size by the noise as it passes a joint that slips all the time."""
    (k,) = one.sizes
    return float(np.sqrt(np.linalg.pinv(one.left.blocks.information.sum(axis=0))[k, k]))


@pytest.fixture(scope="module")
def of_nothing() -> list[DrawnSizes]:
    """What slow errors of the torque make of a change of one record that there is not."""
    return [sizes(slow_errors(records({}), seed, 0.01), {CHANGE: 0.01}, CHANGE) for seed in SEEDS]


def test_sizes_scatter_as_drawn_ones_do(of_nothing: list[DrawnSizes]) -> None:
    found = np.array([one.found[0] for one in of_nothing])
    drawn = np.array([np.sqrt(one.variances[0]) for one in of_nothing])
    slipping = np.array([through_a_slipping_joint(one) for one in of_nothing])
    assert np.sqrt(np.mean((found / slipping) ** 2)) > 4.0
    assert 0.5 < np.sqrt(np.mean((found / drawn) ** 2)) < 2.5


def test_none_stands_out(of_nothing: list[DrawnSizes]) -> None:
    assert min(one.p_value(LEVEL) for one in of_nothing) > LEVEL


def test_both_ways_tell_of_an_effect_that_is_there() -> None:
    there = sizes(slow_errors(records(STRIBECK), 0, 0.01), STRIBECK, "motor.stribeck")
    assert there.found[0] == pytest.approx(STRIBECK["motor.stribeck.dFs"], abs=4.0 * np.sqrt(there.variances[0]))
    assert there.p_value_along_the_motion < LEVEL
    assert there.p_value_among_draws < LEVEL


def test_simulations_are_asked_for_only_where_the_linear_motion_does_not_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    there = sizes(records(STRIBECK), STRIBECK, "motor.stribeck")
    monkeypatch.setattr(DrawnSizes, "p_value_among_draws", property(lambda _: pytest.fail("there is no need")))
    assert there.p_value(LEVEL) < LEVEL


def test_too_few_draws_tell_nothing(of_nothing: list[DrawnSizes], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotid.diagnosis.noise.colour.drawn_residuals", lambda *_: [])
    fresh = DrawnSizes(of_nothing[0].left, of_nothing[0].sizes, of_nothing[0].beside)
    assert fresh.p_value_among_draws == 1.0
    assert fresh.variances.tolist() == [0.0]


def a_curve(made: list[Record]) -> tuple[RefittedModel, list[Array]]:
    """A model, and the forces of the curve that explains most of what it leaves."""
    state = begun(made)
    return state.first, list(next(iter(fit_curves(state.first, state.data))).basis.forces)


def among_draws(model: RefittedModel, forces: list[Array]) -> float:
    return curve_among_draws(model, scans(model.fitted, model.unknowns, (), forces))


def test_a_curve_of_what_is_there_stands_out() -> None:
    assert curve_p_value(*a_curve(records(STRIBECK))) < LEVEL


def test_a_curve_of_slow_errors_does_not() -> None:
    """Simulations allow it far more than a joint that slips."""
    model, forces = a_curve(slow_errors(records({}), 0, 0.01))
    assert curve_p_value(model, forces) > LEVEL
    left, first = left_by(model, forces), len(model.unknowns.parameters)
    at = range(first, first + forces[0].shape[1])
    by_linear_noise = by_noise(left.blocks, at, left.energy, model.samples)
    assert np.log(among_draws(model, forces)) > 0.5 * np.log(by_linear_noise)


def far_away(far: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Draws that run away, as of a joint that a piece of a record simulates hardly at all."""
    draw = colour.drawn_residuals
    monkeypatch.setattr(colour, "drawn_residuals", lambda *asked: [far * one for one in draw(*asked)])


def test_how_large_draws_are_tells_nothing_of_a_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    """A slow error shifts where a motor rests, and draws of one noise differ by orders of magnitude."""
    assert among_draws(*a_curve(records(STRIBECK))) < LEVEL
    far_away(30.0, monkeypatch)
    assert among_draws(*a_curve(records(STRIBECK))) < LEVEL


def test_a_curve_among_draws_whose_energy_is_beyond_numbers_may_be_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    far_away(1e160, monkeypatch)
    assert among_draws(*a_curve(records(STRIBECK))) > 0.9


def test_sizes_among_draws_the_square_of_whose_energy_is_beyond_numbers_may_be_anything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    far_away(1e80, monkeypatch)
    there = sizes(records(STRIBECK), STRIBECK, "motor.stribeck")
    assert there.p_value_among_draws == 1.0


def test_a_curve_of_which_too_little_could_be_drawn_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    model, forces = a_curve(records(STRIBECK))
    monkeypatch.setattr("robotid.diagnosis.noise.colour.drawn_residuals", lambda *_: [])
    assert curve_p_value(model, forces) == 1.0
