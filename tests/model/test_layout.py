"""Which rows of the state are the motor's."""

from __future__ import annotations

import pytest
from support.paper_joint import STRUCTURE

from robotid.catalogue import assemble


@pytest.mark.parametrize("angle", [True, False])
def test_the_motors_rows_are_those_of_its_state_names(angle: bool) -> None:
    joint = assemble(STRUCTURE, angle=angle)
    assert joint.state_names[joint.motor_speed] == "dphi_m"
    assert joint.state_names[joint.motor_states] == (("phi_m",) if angle else ()) + ("dphi_m",)
    assert joint.output_row("speed") == joint.motor_speed


def test_a_joint_that_keeps_its_angle_says_where() -> None:
    joint = assemble(STRUCTURE, angle=True)
    assert joint.state_names[joint.motor_angle] == "phi_m"
    assert joint.output_row("position") == joint.motor_angle


def test_a_joint_without_its_angle_refuses_to_name_a_row() -> None:
    with pytest.raises(ValueError, match="does not keep its angle"):
        assemble(STRUCTURE).output_row("position")
