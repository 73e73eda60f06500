"""Torques that depend on the motor's angle, at the recorded angle rather than at the simulated one."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from robotid.catalogue import assemble, with_effect
from robotid.model.companion import Course, SmoothCourse
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.model.structure import Structure

RIGID = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
FLEXIBLE = Structure(("motor.inertia", "motor.coulomb", "gear.spring", "arm.inertia"), gear_ratio=0.01)
RECORDED = SmoothCourse(np.array([[2.0, 2.0], [0.0, 0.0], [0.0, 0.0]]), sampling_time=1.0)


@dataclass(frozen=True)
class Log:
    name: str = "log"
    courses: dict[str, Course] = field(default_factory=dict)
    motor_course: Course = RECORDED


@pytest.mark.parametrize("effect", ["motor.cogging", "motor.position_friction", "motor.gravity"])
def test_what_turns_with_the_motor_is_added_at_the_recorded_angle(effect: str) -> None:
    assert with_effect(RIGID, effect).recorded_angle
    assert with_effect(RIGID, effect).terms[-1] == effect


@pytest.mark.parametrize("effect", ["arm.gravity", "gear.transmission_error"])
def test_so_is_what_turns_with_the_arm_or_watches_the_motor(effect: str) -> None:
    assert with_effect(FLEXIBLE, effect).recorded_angle


@pytest.mark.parametrize(
    "effect", ["motor.stribeck", "gear.backlash", "torque.torque_delay", "record_change.day2.motor.coulomb.Fc"]
)
def test_other_effects_change_nothing(effect: str) -> None:
    joint = FLEXIBLE if effect.startswith("gear") else RIGID
    assert with_effect(joint, effect) == joint.extended(effect)
    assert not with_effect(joint, effect).recorded_angle


def test_a_joint_that_follows_its_angle_still_does_with_one_effect_more() -> None:
    assert with_effect(with_effect(RIGID, "motor.cogging"), "motor.stribeck").recorded_angle


def test_only_a_joint_with_such_a_torque_follows_a_record() -> None:
    plain = assemble(replace(RIGID, recorded_angle=True), angle=True)
    assert not plain.follows_angle
    assert plain.along(Log()) is plain
    cogged = assemble(with_effect(RIGID, "motor.cogging"))
    assert cogged.follows_angle
    assert cogged.depends_on_record
    assert not cogged.reads_companions
    assert not assemble(RIGID.extended("motor.cogging")).follows_angle


def right_side(joint: Joint, angle: float) -> tuple[float, float]:
    """Acceleration of the motor at an angle that is a state, and its derivative to that."""
    values = {"motor.cogging.A": 0.3, "motor.cogging.B": 0.1, "motor.cogging.n": 4.0}
    theta = joint.parameters().with_values(values).values
    x, s = np.array([[angle], [3.0]]), np.ones((1, 1))
    at = joint.evaluate(x, np.zeros(1), s, np.zeros(1), theta, columns=DerivativeColumns())
    return float(at.f[1, 0]), float(at.A[1, 0, 0])


def test_the_torque_acts_at_the_recorded_angle_whatever_was_simulated() -> None:
    structure = with_effect(RIGID, "motor.cogging")
    free, bound = assemble(structure), assemble(structure).along(Log())
    there, slope = right_side(free, 2.0)
    assert slope != 0.0
    for angle in (2.0, 2.4):
        assert right_side(bound, angle) == (there, 0.0)
    assert right_side(free, 2.4)[0] != there
