"""A curve along the speed as a term: its derivatives, and a motion that an effect of the same shape makes as well."""

from __future__ import annotations

import numpy as np
import pytest
from small_bench import AXIS, TRUTH, records

from robotid.judge.free_curve import FreeCurve
from robotid.model.port import Port
from robotid.model.term import Motion
from robotid.simulate.assemble import assemble
from robotid.simulate.simulate import simulate

KNOTS = np.array([-20.0, -5.0, 0.0, 0.0, 5.0, 20.0])
VALUES = np.array([0.3, 0.25, 0.1, -0.1, -0.2, -0.4])


def motion(v: float, s: float) -> Motion:
    zero = np.zeros(1)
    return Motion(zero, np.array([v]), zero, np.array([s]), zero, np.zeros((0, 1)))


@pytest.mark.parametrize(("v", "s"), [(2.0, 1.0), (-7.0, -1.0), (0.01, 0.4), (30.0, 1.0), (-30.0, -1.0)])
def test_partials_are_the_derivatives_of_the_torque(v: float, s: float) -> None:
    curve, step = FreeCurve(KNOTS, VALUES), 1e-6
    found = curve.partials(motion(v, s), ())
    for name, (dv, ds) in {"v": (step, 0.0), "s": (0.0, step)}.items():
        difference = curve.torque(motion(v + dv, s + ds), ()) - curve.torque(motion(v - dv, s - ds), ())
        assert getattr(found, name) == pytest.approx(difference / (2 * step), abs=1e-6)


def test_a_curve_that_is_coulomb_and_viscous_friction_moves_the_axis_as_they_do() -> None:
    record = records({}, quiet=True)[0]
    joint = assemble(AXIS)
    truth = joint.parameters().with_values(TRUTH).values
    less = joint.parameters().with_values(TRUTH | {"motor.viscous.Fv": 0.005, "motor.coulomb.Fc": 0.5}).values
    ends = np.array([-100.0, 0.0, 0.0, 100.0])
    curve = FreeCurve(ends, np.array([1.1, 0.1, -0.1, -1.1]))
    curved = joint.with_more(terms=[(Port.MOTOR, curve)])
    assert simulate(curved, less, record).dphi_m == pytest.approx(simulate(joint, truth, record).dphi_m, abs=1e-8)
