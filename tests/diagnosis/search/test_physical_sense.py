"""A cause must make physical sense and differ from nothing, within what is known of its parameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.sensed_step import step_to
from support.small_bench import STRIBECK, TRUTH, fitted, records

from robotid.catalogue import assemble
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import AS_IT_IS, refit
from robotid.diagnosis.search.acceptance import OBJECTIONS
from robotid.diagnosis.search.physical_sense import is_not_physical, is_uncertain, port_range
from robotid.estimate.fitted_model import fitted_model
from robotid.model.structure import Structure

CRITERIA = Criteria()
WARM_UP = "motor.thermal_friction"


def test_no_gearbox_warms_up_in_a_second() -> None:
    why = is_not_physical(step_to(WARM_UP, {"c": 0.5, "T": 1.19}, {"T": 0.1, "c": 0.01}), CRITERIA)
    assert why == "makes no sense: T = 1.19 s, and nothing warms up so fast"
    assert is_not_physical(step_to(WARM_UP, {"c": 0.5, "T": 12.0}, {"T": 0.1, "c": 0.01}), CRITERIA) is None


def test_what_may_lie_in_the_range_is_not_objected_to() -> None:
    assert is_not_physical(step_to(WARM_UP, {"c": 0.5, "T": 1.5}, {"T": 0.3, "c": 0.01}), CRITERIA) is None


def test_what_no_record_tells_is_no_law_where_it_makes_no_sense() -> None:
    """It is known less well than to its own size, and what it seems to be is outside the range."""
    why = is_not_physical(step_to(WARM_UP, {"c": 0.5, "T": 1.5}, {"T": 600.0, "c": 0.01}), CRITERIA)
    assert why == "makes no sense: T = 1.5 s, known to 6e+02, and nothing warms up so fast"
    assert is_not_physical(step_to(WARM_UP, {"c": 0.5, "T": 12.0}, {"T": 600.0, "c": 0.01}), CRITERIA) is None


def test_a_stribeck_speed_beyond_the_motion_is_none() -> None:
    """The axis is at rest."""
    why = is_not_physical(step_to("motor.stribeck", {"dFs": 0.1, "vs": 1.0}, {"vs": 0.01}), CRITERIA)
    assert why is not None
    assert "the motion never reaches it" in why


def test_a_size_within_its_own_uncertainty_is_no_finding() -> None:
    why = is_uncertain(step_to("motor.presliding", {"w": 2e-4, "s0": 30.0, "s1": 0.0}, {"w": 7e-3}), CRITERIA)
    assert why == "is not certain to be there: w = 0.0002, known to 0.007"
    assert is_uncertain(step_to("motor.presliding", {"w": 0.1, "s0": 30.0, "s1": 0.0}, {"w": 7e-3}), CRITERIA) is None


def test_a_shape_that_is_hardly_known_leaves_a_size_certain() -> None:
    """Of what warms up slowly only the slope is known; and less of a size than itself is nothing."""
    for deviation, why in ((0.25, None), (1.0, "is not certain to be there: c = 0.5, known to 1")):
        step = step_to(WARM_UP, {"c": 0.5, "T": 20.0}, {"c": 0.01, "T": 1.0})
        factor, names = step.after.factor.copy(), step.after.parameters.names
        c, T = (names.index(f"{WARM_UP}.{symbol}") for symbol in "cT")
        factor[c, T] = -100.0 * deviation
        assert is_uncertain(replace(step, after=replace(step.after, factor=factor)), CRITERIA) == why


def test_sine_and_cosine_are_one_size() -> None:
    spread = {"A": 0.01, "B": 0.01, "n": 0.01}
    assert is_uncertain(step_to("motor.cogging", {"A": 0.0, "B": 0.05, "n": 6.0}, spread), CRITERIA) is None
    assert is_uncertain(step_to("motor.cogging", {"A": 0.01, "B": 0.02, "n": 6.0}, spread), CRITERIA) is not None


def test_both_are_asked_of_every_cause() -> None:
    assert {is_not_physical, is_uncertain} <= set(OBJECTIONS)


def test_the_motion_of_the_records_is_that_of_the_effect_s_port() -> None:
    made = list(records(STRIBECK))
    fit = fitted_model(fitted(made))
    segments = tuple(Segment(r, UNIT_WHITENING) for r in made[:2])
    data = EvaluationData(segments, (), "speed", estimate_states=True, noise_reached=True, torque_errors=None)
    model = refit(fit.joint.structure, [fit.parameters], data)
    offered = port_range(model, "motor.viscous")
    assert offered.duration == pytest.approx(max(r.duration for r in made[:2]))
    assert offered.speed == pytest.approx(max(float(np.abs(r.dphi_m).max()) for r in made[:2]), rel=0.1)
    assert offered.travel == pytest.approx(max(float(np.ptp(r.phi_m)) for r in made[:2]), rel=0.1)
    assert port_range(model, "torque.torque_lag").travel == pytest.approx(offered.travel, rel=0.01)


@pytest.mark.parametrize("effect", ["gear.transmission_error", "motor.cogging", "motor.position_friction"])
def test_what_repeats_with_the_turns_of_the_motor_has_its_travel(effect: str) -> None:
    """A transmission error twists the gear, and follows the motor."""
    made = list(records({}))[1]
    terms = ("motor.inertia", "motor.viscous", "motor.coulomb", "gear.spring", "gear.damper", "arm.inertia")
    structure = Structure((*terms, effect), gear_ratio=0.01)
    data = EvaluationData(
        (Segment(made, UNIT_WHITENING),), (), "speed", estimate_states=True, noise_reached=True, torque_errors=None
    )
    start = assemble(structure).parameters().with_values(TRUTH | {"gear.spring.k1": 1e6, "arm.inertia.J": 20.0})
    model = refit(structure, [start], data, options=AS_IT_IS)
    offered = port_range(model, effect)
    assert offered.travel > 1.0
    assert offered.travel == pytest.approx(port_range(model, "torque.torque_lag").travel)
    assert offered.speed > 1.0
