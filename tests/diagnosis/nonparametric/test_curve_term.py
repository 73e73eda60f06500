"""A curve as a term: its derivatives, and a motion that an effect of the same shape makes as well."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_bench import AXIS, TRUTH, records

from robotid.catalogue import assemble
from robotid.diagnosis.misfit.curve import BY_ACCELERATION, BY_DIRECTION, BY_SPEED, BY_TWIST
from robotid.diagnosis.nonparametric.basis import Variable
from robotid.diagnosis.nonparametric.curve_course import can_act_in_time
from robotid.diagnosis.nonparametric.curve_term import FreeCurve, can_act
from robotid.model.port import Port
from robotid.model.structure import Structure
from robotid.model.term import Motion
from robotid.simulation.simulate import simulate

KNOTS = np.array([-20.0, -5.0, 0.0, 0.0, 5.0, 20.0])
VALUES = np.array([0.3, 0.25, 0.1, -0.1, -0.2, -0.4])


SPEED = Variable("dphi_m", "rad/s", split=True)
TWIST, RATE = Variable("twist", "rad", gear=True), Variable("dtwist", "rad/s", gear=True)
ALONG = [Variable("phi_m", "rad", counted) for counted in ("", BY_DIRECTION, BY_SPEED, BY_ACCELERATION)]
ALONG += [TWIST, RATE, Variable("t", "s", BY_DIRECTION)]
STEP = 1e-6
GEARED = Structure((*AXIS.terms, "gear.spring", "gear.damper", "arm.inertia"), gear_ratio=0.01)
GEARED_TRUTH = TRUTH | {"gear.spring.k1": 2e5, "gear.damper.d": 300.0, "arm.inertia.J": 100.0}


def motion(x: float, v: float, s: float, a: float = 1.5) -> Motion:
    """At the time x."""
    return Motion(np.array([x]), np.array([v]), np.array([a]), np.array([s]), np.array([x]), np.zeros((0, 1)))


@pytest.mark.parametrize(("v", "s"), [(2.0, 1.0), (-7.0, -1.0), (0.01, 0.4), (30.0, 1.0), (-30.0, -1.0)])
def test_partials_are_the_derivatives_of_the_torque(v: float, s: float) -> None:
    _same_derivatives(FreeCurve(SPEED, KNOTS, VALUES), 0.0, v, s)


@pytest.mark.parametrize("variable", ALONG)
def test_so_they_are_along_other_variables(variable: Variable) -> None:
    curve = FreeCurve(variable, np.linspace(-4.0, 4.0, 5), np.array([0.3, 0.1, -0.2, 0.2, 0.5]))
    for x, v, s in [(1.3, 2.1, 1.0), (-0.7, -3.0, -1.0), (3.1, 0.01, 0.4), (9.0, 1.0, 1.0)]:
        _same_derivatives(curve, x, v, s)


def _same_derivatives(curve: FreeCurve, x: float, v: float, s: float) -> None:
    found = curve.partials(motion(x, v, s), ())
    steps = {"v": (0.0, STEP, 0.0, 0.0), "s": (0.0, 0.0, STEP, 0.0), "a": (0.0, 0.0, 0.0, STEP)}
    if curve.argument != "t":
        steps["x"] = (STEP, 0.0, 0.0, 0.0)
    for name, (dx, dv, ds, da) in steps.items():
        after, before = (motion(x + k * dx, v + k * dv, s + k * ds, 1.5 + k * da) for k in (1, -1))
        difference = curve.torque(after, ()) - curve.torque(before, ())
        assert getattr(found, name) == pytest.approx(difference / (2 * STEP), abs=1e-6)


def test_a_curve_that_is_coulomb_and_viscous_friction_moves_the_axis_as_they_do() -> None:
    record = records({}, quiet=True)[0]
    joint = assemble(AXIS)
    truth = joint.parameters().with_values(TRUTH).values
    less = joint.parameters().with_values(TRUTH | {"motor.viscous.Fv": 0.005, "motor.coulomb.Fc": 0.5}).values
    ends = np.array([-100.0, 0.0, 0.0, 100.0])
    curve = FreeCurve(SPEED, ends, np.array([1.1, 0.1, -0.1, -1.1]))
    curved = joint.with_more(terms=[(Port.MOTOR, curve)])
    assert simulate(curved, less, record).dphi_m == pytest.approx(simulate(joint, truth, record).dphi_m, abs=1e-8)


@pytest.mark.parametrize(
    ("variable", "name"), [(TWIST, "gear.spring.k1"), (RATE, "gear.damper.d")], ids=["spring", "damper"]
)
def test_a_curve_on_the_gear_that_is_a_spring_or_a_damper_moves_the_arm_as_that_does(
    variable: Variable, name: str
) -> None:
    joint, less = assemble(GEARED), GEARED_TRUTH | {name: 0.6 * GEARED_TRUTH[name]}
    truth, weaker = (joint.parameters().with_values(values).values for values in (GEARED_TRUTH, less))
    missing = 0.4 * GEARED_TRUTH[name]
    curve = FreeCurve(variable, np.array([-1.0, 1.0]), np.array([missing, -missing]))
    record = records({}, quiet=True)[0]
    found = simulate(joint.with_more(terms=[(Port.GEAR, curve)]), weaker, record)
    assert found.dphi_m == pytest.approx(simulate(joint, truth, record).dphi_m, abs=1e-8)


def test_a_curve_in_proportion_to_the_acceleration_that_is_an_inertia_moves_the_axis_as_it_does() -> None:
    joint = assemble(AXIS)
    truth, lighter = (
        joint.parameters().with_values(TRUTH | {"motor.inertia.J": share * TRUTH["motor.inertia.J"]}).values
        for share in (1.0, 0.7)
    )
    missing = 0.3 * TRUTH["motor.inertia.J"]
    curve = FreeCurve(Variable("phi_m", "rad", BY_ACCELERATION), np.array([-1.0, 1.0]), np.full(2, -missing))
    record = records({}, quiet=True)[0]
    found = simulate(joint.with_more(terms=[(Port.MOTOR, curve)]), lighter, record)
    assert found.dphi_m == pytest.approx(simulate(joint, truth, record).dphi_m, abs=1e-8)


def test_a_stiffness_along_the_motor_s_angle_cannot_act_for_the_gear_does_not_know_that_angle() -> None:
    joint = assemble(GEARED)
    assert can_act(RATE, joint)
    placed = Variable("phi_m", "rad", BY_TWIST, gear=True)
    assert not can_act(placed, joint)
    assert can_act_in_time(placed)


@pytest.mark.parametrize("along", ["tau_m", "ddphi_m"])
def test_what_drives_a_motion_is_no_torque_in_time_for_it_tells_how_the_machine_moved(along: str) -> None:
    assert not can_act_in_time(Variable(along, "Nm"))
