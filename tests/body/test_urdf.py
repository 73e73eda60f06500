from __future__ import annotations

import numpy as np
import pytest

from robotid.body import pinocchio_model
from robotid.body.chain import Chain
from robotid.body.consistent import body, parameters_of, pseudo_inertia
from robotid.body.regressor import torques
from robotid.body.urdf import chain_of_urdf, fixed_masses
from robotid.errors import ConfigError

GRAVITY = np.array([0.0, 0.0, -9.81])
ARM = """<?xml version="1.0"?>
<robot name="arm">
  <link name="world"/>
  <link name="column">
    <inertial><origin xyz="0 0.1 0.2" rpy="0.3 0 0.2"/><mass value="20"/>
      <inertia ixx="1.0" ixy="0.02" ixz="0" iyy="1.1" iyz="0" izz="0.8"/></inertial>
  </link>
  <link name="rod"/>
  <link name="flange">
    <inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
  </link>
  <joint name="j1" type="revolute"><parent link="world"/><child link="column"/>
    <origin xyz="0 0 0.6" rpy="0 0 0.5"/><axis xyz="0 0 -2"/>
    <limit lower="-3" upper="3" effort="100" velocity="2"/></joint>
  <joint name="j2" type="continuous"><parent link="column"/><child link="rod"/>
    <origin xyz="0.3 0 0.1" rpy="0 -1.5 0"/><axis xyz="0 1 0"/></joint>
  <joint name="mount" type="fixed"><parent link="rod"/><child link="flange"/>
    <origin xyz="0.7 0 0" rpy="0 0 1"/></joint>
</robot>"""
JOINTS = ("j1", "j2")


def arm(text: str = ARM, joints: tuple[str, ...] = JOINTS) -> Chain:
    return chain_of_urdf(text, joints, GRAVITY, "arm.urdf")


def test_axes_sit_where_the_file_says() -> None:
    first, second = arm().joints
    assert first.offset.tolist() == [0.0, 0.0, 0.6]
    assert first.axis.tolist() == [0.0, 0.0, -1.0]
    assert first.rotation @ [1.0, 0.0, 0.0] == pytest.approx([np.cos(0.5), np.sin(0.5), 0.0])
    assert second.rotation @ [1.0, 0.0, 0.0] == pytest.approx([np.cos(1.5), 0.0, np.sin(1.5)])


def test_what_is_fixed_to_a_link_is_part_of_it() -> None:
    expected = body(2.0, np.array([0.7, 0.0, 0.0]), 0.01 / 2 / 2 * np.eye(3))
    assert arm().joints[1].inertia == pytest.approx(expected)


def test_a_link_without_mass_is_unknown_and_moves_with_what_carries_it() -> None:
    bare = ARM.replace('<mass value="2"/>', '<mass value="0"/>')
    assert arm(bare).joints[1].inertia is None
    held = fixed_masses(arm(bare))
    assert [joint.fixed for joint in held.joints] == [True, False]


def test_a_fixed_joint_before_an_axis_shifts_it() -> None:
    lifted = ARM.replace('<link name="world"/>', '<link name="world"/><link name="floor"/>').replace(
        "</robot>",
        '<joint name="lift" type="fixed"><parent link="floor"/><child link="world"/>'
        '<origin xyz="1 0 2" rpy="0 0 1.5707963267948966"/></joint></robot>',
    )
    assert arm(lifted).joints[0].offset == pytest.approx([1.0, 0.0, 2.6])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("<robot", "<sdf"), "not XML|not <robot>"),
        (('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>'), "axis without direction"),
        (('<axis xyz="0 1 0"/>', '<axis xyz="0 1"/>'), "expected three numbers"),
        (('type="continuous"', 'type="prismatic"'), "prismatic, not revolute"),
        (('<parent link="column"/>', ""), "has no parent"),
        (('type="fixed"', 'type="revolute"'), "mount moves, and is not part"),
        (('<?xml version="1.0"?>', '<!DOCTYPE robot [<!ENTITY a "b">]>'), "no document type"),
    ],
)
def test_what_is_no_chain_is_refused(change: tuple[str, str], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        arm(ARM.replace(*change))


def test_a_joint_that_is_not_there_is_refused_with_those_that_are() -> None:
    with pytest.raises(ConfigError, match="no joint") as caught:
        arm(joints=("j1", "j3"))
    assert "j1, j2" in str(caught.value.hint)


def test_a_joint_that_is_left_out_is_refused() -> None:
    with pytest.raises(ConfigError, match="turns about j1, j2"):
        arm(joints=("j2",))


def test_parameters_in_another_frame_are_those_of_the_same_mass() -> None:
    from robotid.body.urdf import moved

    own = body(3.0, np.array([0.1, 0.2, 0.3]), np.diag([0.1, 0.2, 0.3]))
    there = moved(own, np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([1.0, 0, 0]))
    assert there[:4] == pytest.approx([3.0, 3.0 * 0.8, 0.3, 0.9])
    assert parameters_of(pseudo_inertia(there)) == pytest.approx(there)


@pytest.mark.skipif(not pinocchio_model.available(), reason="pinocchio (the extra `body`) is not installed")
def test_the_file_is_read_as_pinocchio_reads_it() -> None:
    import pinocchio

    model = pinocchio.buildModelFromXML(ARM)
    model.gravity = pinocchio.Motion(np.concatenate([GRAVITY, np.zeros(3)]))
    rng, data = np.random.default_rng(1), model.createData()
    chain = arm()
    links = np.concatenate([joint.inertia for joint in chain.joints if joint.inertia is not None])
    angle, dq, ddq = rng.normal(size=(3, 2, 1))
    # pinocchio keeps the cosine and sine of a continuous joint
    q = np.array([angle[0, 0], np.cos(angle[1, 0]), np.sin(angle[1, 0])])
    expected = pinocchio.rnea(model, data, q, dq[:, 0], ddq[:, 0])
    assert torques(chain, links, angle, dq, ddq)[:, 0] == pytest.approx(expected, rel=1e-9)
