"""A cause stands out of noise of any colour, which explains some of every residual."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from support.small_bench import QUICK, STRIBECK, begun, fitted, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.procedure import diagnose
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression
from robotid.diagnosis.search import coloured
from robotid.diagnosis.search.coloured import Left, Tried, confirmation, explains_more, in_colour, left_by, p_value
from robotid.diagnosis.search.physical_sense import amplitudes
from robotid.diagnosis.search.state import is_covered, share_removed
from robotid.errors import NumericsError
from robotid.signals.record import Record

TRIED = Tried(300, 30)
FEW = Criteria(skip=("power_friction", "thermal_friction", "backlash"))


def slow_errors(made: list[Record], seed: int, size: float = 0.02, pole: float = 0.99) -> list[Record]:
    """The records with a red error of their torque."""
    rng = np.random.default_rng(seed)
    errors = (lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], rng.standard_normal(len(one))) for one in made)
    return [replace(one, tau_m=one.tau_m + size * error) for one, error in zip(made, errors, strict=True)]


def with_effect(made: list[Record], values: Mapping[str, float]) -> RefittedModel:
    state = begun(made)
    effect = next(iter(values)).rpartition(".")[0]
    structure, start = extended(state.first, effect, values)
    return refit(structure, [start], state.data, state.first.trajectories)


def test_a_true_cause_stands_out() -> None:
    model = with_effect(records(STRIBECK), STRIBECK)
    left = left_by(model)
    assert left.energy == pytest.approx(1.0, abs=0.1)
    assert p_value(model, "motor.stribeck", left, TRIED) < 1e-3


def test_slow_errors_of_the_torque_are_no_cause() -> None:
    """By the noise of the sensors alone many an effect would be one."""
    sharp, honest = [], []
    for seed in range(4):
        model = with_effect(slow_errors(records({}), seed), {"motor.constant_torque.tau0": 0.01})
        std = float(np.sqrt(model.covariance[3, 3]))
        sharp.append(abs(model.parameters["motor.constant_torque.tau0"]) / std)
        honest.append(p_value(model, "motor.constant_torque", left_by(model), TRIED))
    assert max(sharp) > 4.0
    assert min(honest) > 1e-3


@pytest.mark.parametrize("seed", [pytest.param(seed, marks=pytest.mark.slow) for seed in (3, 5)])
def test_a_machine_whose_torque_has_slow_errors_is_given_no_cause(seed: int) -> None:
    made = slow_errors(records({}), seed)
    assert diagnose(fitted(made), made, FEW).causes == ()


def test_records_that_were_held_out_confirm_an_effect_only_where_it_is_as_large() -> None:
    """The size that the fit found counts there."""
    model = with_effect(records(STRIBECK), STRIBECK)
    sizes = amplitudes(model, "motor.stribeck")
    third = {"motor.stribeck.dFs": 0.05, "motor.stribeck.vs": 1.0}
    p = []
    for there in (STRIBECK, third):
        held_out = records(there)[2:]
        other = with_effect([replace(one, role="estimate") for one in held_out], STRIBECK)
        p.append(confirmation(other, "motor.stribeck", sizes))
    assert p[0] < 1e-6
    assert p[1] == 1.0


def test_amplitudes_that_take_each_others_place_are_of_the_same_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the constant and the cosine of a coupling, where the angle hardly moves."""
    rng = np.random.default_rng(1)
    motion = rng.standard_normal((20, 1, 200))
    columns = np.concatenate([motion, motion + 0.05 * rng.standard_normal(motion.shape)], axis=1)
    information = columns @ columns.transpose(0, 2, 1)
    blocks = BlockedRegression(information, np.zeros((20, 2)), np.zeros(20))
    model = with_effect(records(STRIBECK), STRIBECK)
    monkeypatch.setattr(coloured, "left_by", lambda _: replace(left_by(model), blocks=blocks, energy=1.0))
    monkeypatch.setattr(RefittedModel, "own_columns", lambda *_: [0, 1])
    p = []
    for found in ({0: 0.0, 1: 1.6}, {0: 0.0, 1: 4.0}):
        monkeypatch.setattr(coloured, "amplitudes", lambda *_, found=found: found)
        p.append(confirmation(model, "arm.coupling[a1]", {0: 0.7, 1: 0.9}))
    assert p[0] < 1e-6
    assert p[1] == 1.0


@pytest.mark.parametrize(("scatter", "confirmed"), [(3.0, True), (300.0, False)])
def test_blocks_of_the_records_held_out_must_agree_where_enough_of_them_tell(
    scatter: float, *, confirmed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where a friction that wanders on both days looks like one that falls with the speed."""
    model = with_effect(records(STRIBECK), STRIBECK)
    apart = scatter * np.where(np.arange(20) % 2, 1.0, -1.0)
    blocks = BlockedRegression(np.full((20, 1, 1), 200.0), apart[:, None], np.zeros(20))
    monkeypatch.setattr(coloured, "left_by", lambda _: replace(left_by(model), blocks=blocks, energy=1.0))
    monkeypatch.setattr(RefittedModel, "own_columns", lambda *_: [0])
    monkeypatch.setattr(coloured, "amplitudes", lambda *_: {0: 0.15})
    assert (confirmation(model, "motor.stribeck", {0: 0.15}) < 1e-3) is confirmed


def test_a_fit_of_held_out_records_that_no_joint_can_be_confirms_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def runs_away(_: RefittedModel) -> Left:
        raise NumericsError("the joint runs away within a sampling time")

    monkeypatch.setattr(coloured, "left_by", runs_away)
    assert confirmation(with_effect(records(STRIBECK), STRIBECK), "motor.stribeck", {0: 0.15}) == 1.0


def test_records_that_were_held_out_decide_where_too_few_blocks_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside errors in which the fitted records hardly show the effect."""
    model = with_effect(records(STRIBECK), STRIBECK)
    hidden = replace(left_by(model), energy=1e6)
    held_out = [replace(one, role="estimate") for one in records(STRIBECK)[2:]]
    other = with_effect(held_out, STRIBECK)
    p = []
    for few in (False, True):
        monkeypatch.setattr(coloured, "are_too_few", lambda *_, few=few: few)
        p.append(p_value(model, "motor.stribeck", hidden, TRIED, lambda: other))
    assert p[0] > 0.05
    assert p[1] < 1e-6


def test_where_noise_covers_the_misfit_a_share_is_of_the_plain_squared_error() -> None:
    before, after = begun(records(STRIBECK)), with_effect(records(STRIBECK), STRIBECK)
    assert not is_covered(before.first, before.data)
    loud = replace(before.data, fitted=tuple(ten_times_louder(one) for one in before.data.fitted))
    assert is_covered(before.first, loud)
    squared = [sum(float(one.residual @ one.residual) for one in m.fitted) for m in (before.first, after)]
    assert share_removed(before.first, before.first, after, loud) == pytest.approx(1.0 - squared[1] / squared[0])


def ten_times_louder(segment: Segment) -> Segment:
    sections = segment.whitening.sections.copy()
    sections[0, :3] /= 10.0
    return replace(segment, whitening=replace(segment.whitening, sections=sections))


def test_a_shape_that_may_be_any_beside_the_amplitude_leaves_the_effect_what_it_is() -> None:
    """As the time of warming up beyond the end of a record, where it and the size make one slope."""
    model = with_effect(records(STRIBECK), STRIBECK)
    left = left_by(model)
    size, shape = model.own_columns("motor.stribeck")
    information = left.blocks.information.copy()
    information[:, shape], information[:, :, shape] = information[:, size], information[:, :, size]
    information[:, shape, shape] *= 1.0 + 1e-6
    alike = replace(left, blocks=replace(left.blocks, information=information))
    assert p_value(model, "motor.stribeck", alike, TRIED) < 1e-3


def test_a_model_explains_more_only_where_less_is_left_beside_the_same_noise() -> None:
    made = records(STRIBECK)
    state, with_it = begun(made, QUICK), with_effect(made, STRIBECK)
    for first, last, more in ((state.first, with_it, True), (with_it, state.first, False)):
        left = left_by(last)
        assert explains_more(first, last, left, in_colour(last, state.data, left.noise)) is more


def test_to_first_order_alone_a_model_that_is_far_off_explains_nothing_more() -> None:
    """Its columns may explain all of a residual that no parameters do."""
    made = records(STRIBECK)
    state, with_it = begun(made, QUICK), with_effect(made, STRIBECK)
    left = left_by(with_it)
    coloured = in_colour(with_it, state.data, left.noise)
    assert explains_more(state.first, with_it, replace(left, energy=2.0 * left.energy + 1e6), coloured)
