"""Models in other programs: what they are there, what is left out and what that costs, and that they move as here."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.handed_models import RATIO, STEP, VALUES, driven, handed

from robotid.errors import ConfigError
from robotid.export.handover.cost import costs
from robotid.export.handover.elements import Element, elements
from robotid.export.handover.handed_model import HandedModel
from robotid.export.handover.target import Target
from robotid.export.targets import TARGETS
from robotid.export.targets.mujoco import Mujoco
from robotid.export.targets.python_function import PythonFunction
from robotid.export.targets.urdf import Urdf, patched
from robotid.model.array import Array
from robotid.model.port import Port
from robotid.signals.record import Record

RIGID = ("motor.inertia", "motor.viscous", "motor.coulomb")
FLEXIBLE = (*RIGID, "gear.spring", "gear.damper", "arm.inertia")
LARGE = (*FLEXIBLE, "gear.cubic_spring", "arm.viscous", "arm.coulomb")
THREE = (*FLEXIBLE, "link.spring", "link.damper", "tool.inertia")
PLAY = (*FLEXIBLE, "gear.backlash")
OFFSET = (*FLEXIBLE, "motor.constant_torque")
HANGING = (*RIGID, "motor.elastic_load")
ON_ARM = (*FLEXIBLE, "link.third_mass")
SAME_MOTION = 0.01  # of the speed's RMS: what MuJoCo's integrator and its soft dry friction may differ by

ROBOT = """<?xml version="1.0"?>
<robot name="arm">
  <!-- <joint name="elbow" type="revolute"> is below -->
  <joint name="elbow" type="revolute">
    <parent link="a"/>
    <dynamics damping="0.1" friction="0.2"/>
    <limit lower="-1" upper="1"/>
  </joint>
  <joint name='wrist' type='revolute'>
    <parent link="b"/>
  </joint>
  <transmission name="t"><joint name="elbow"><x/></joint></transmission>
</robot>
"""


def test_effects_are_elements_by_their_formulae() -> None:
    model = handed((*LARGE, "gear.backlash", "motor.stribeck", "arm.gravity", "motor.asymmetric_coulomb"))
    more = {"arm.gravity.G": 3.0, "arm.gravity.H": 1.0, "motor.asymmetric_coulomb.dFc": 0.1}
    found = elements(model.with_structure(model.fit.structure, more))
    assert found["motor.inertia"] == Element(Port.MOTOR, inertia=VALUES["motor.inertia.J"])
    assert found["motor.viscous"].damping == pytest.approx(VALUES["motor.viscous.Fv"])
    assert found["motor.coulomb"].friction == VALUES["motor.coulomb.Fc"]
    assert found["gear.spring"].stiffness == pytest.approx(VALUES["gear.spring.k1"])
    assert found["gear.cubic_spring"].cubic == pytest.approx(VALUES["gear.cubic_spring.k3"])
    assert found["gear.cubic_spring"].stiffness == pytest.approx(0.0, abs=1e-3)
    assert found["gear.backlash"].play == VALUES["gear.backlash.gap"]
    assert not {"motor.stribeck", "arm.gravity", "motor.asymmetric_coulomb"} & set(found)


def test_every_target_has_a_file_of_its_name_and_an_ending() -> None:
    assert {target.suffix for target in TARGETS.values()} == set(TARGETS)
    assert set(TARGETS) >= {".xml", ".urdf", ".py", ".m"}


@pytest.mark.parametrize("target", TARGETS.values(), ids=lambda target: target.name)
def test_what_a_target_lacks_is_listed_with_what_it_costs(target: Target) -> None:
    model, _ = driven((*FLEXIBLE, "motor.thermal_friction"))
    found = target.hand_over(model)
    whole = not found.omitted
    assert whole == (not found.costs)
    assert ("It has every effect of the model." in found.text) == whole
    for effect, why in found.omitted.items():
        assert f"It lacks {effect}: {why}." in found.text
    for cost in found.costs:
        assert cost.before > 99.99
        assert cost.after is not None
        assert cost.after < cost.before
        assert cost.difference is not None
        assert cost.difference > 0.0


def test_urdf_is_the_rigid_joint_on_the_joints_side() -> None:
    model, record = driven(LARGE)
    found = Urdf().hand_over(model)
    dynamics = ET.fromstring(found.text).find("joint/dynamics")
    assert dynamics is not None
    assert float(dynamics.get("damping", "")) == pytest.approx(0.02 / RATIO**2 + 5.0)
    assert float(dynamics.get("friction", "")) == pytest.approx(0.4 / RATIO + 3.0)
    assert set(found.omitted) == {"gear.spring", "gear.damper", "gear.cubic_spring"}
    assert "100 kg m2 at the joint" in found.remarks[0]
    reduced = Urdf().reduced(model, found.omitted)
    inertia = reduced.fit["motor.inertia.J"].value
    assert inertia == pytest.approx(0.01 + RATIO**2 * 60.0)
    assert [cost.record for cost in found.costs] == [record.name]


def test_a_rigid_axis_loses_nothing_in_urdf() -> None:
    model, _ = driven(RIGID, ratio=None)
    found = Urdf().hand_over(model)
    assert (found.omitted, found.costs) == ({}, ())
    assert '<dynamics damping="0.02" friction="0.4"/>' in found.text


def test_a_description_is_changed_in_one_joint_alone() -> None:
    lines = ["<!-- new -->", '<dynamics damping="1" friction="2"/>']
    old = '<dynamics damping="0.1" friction="0.2"/>'
    assert patched(ROBOT, "elbow", lines) == ROBOT.replace(old, "\n    ".join(lines))
    found = patched(ROBOT, "wrist", lines)
    assert found.replace("\n    " + "\n    ".join(lines), "") == ROBOT
    wrist = ET.fromstring(found).findall("joint")[1]
    assert [element.tag for element in wrist] == ["parent", "dynamics"]


@pytest.mark.parametrize(("name", "hint"), [("knee", 'no joint "knee"'), ("", "it has 2 joints")])
def test_a_joint_that_is_not_there_is_refused(name: str, hint: str) -> None:
    with pytest.raises(ConfigError, match=hint) as refused:
        patched(ROBOT, name, [""])
    assert "elbow, wrist" in str(refused.value)


def test_the_only_joint_needs_no_name() -> None:
    text = '<robot name="r"><joint name="a" type="fixed"><parent link="b"/></joint></robot>'
    assert ET.fromstring(patched(text, "", ["<dynamics/>"])).find("joint/dynamics") is not None


def test_mjcf_is_on_the_joints_side() -> None:
    root = ET.fromstring(Mujoco().hand_over(handed(LARGE)).text)
    motor, twist = root.findall("worldbody/body/joint")
    assert float(motor.get("armature", "")) == pytest.approx(0.01 / RATIO**2)
    assert float(motor.get("damping", "")) == pytest.approx(0.02 / RATIO**2)
    assert float(motor.get("frictionloss", "")) == pytest.approx(0.4 / RATIO)
    assert [float(k) for k in twist.get("stiffness", "").split()] == pytest.approx([2e4, 0.0, 2e9], abs=1e-3)
    arm = root.find("tendon/fixed")
    assert arm is not None
    assert (float(arm.get("damping", "")), float(arm.get("frictionloss", ""))) == pytest.approx((5.0, 3.0))


def test_comments_of_xml_hold_no_double_hyphen() -> None:
    text = Mujoco().text(handed(RIGID, ratio=None), ["a -- b --- c"])
    comments = re.findall(r"<!--(.*?)-->", text)
    assert all("--" not in comment for comment in comments)
    ET.fromstring(text)


def in_mujoco(text: str, model: HandedModel, record: Record) -> Array:
    """Motor speed in MuJoCo, (n,)."""
    mujoco: Any = pytest.importorskip("mujoco", reason="mujoco is not installed")
    made = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(made)
    speed = np.zeros(len(record))
    for k, torque in enumerate(record.tau_m):
        speed[k] = data.qvel[0] / model.joint.ratio
        data.ctrl[0] = torque
        mujoco.mj_step(made, data)
    return speed


@pytest.mark.parametrize(
    "terms",
    [RIGID, FLEXIBLE, LARGE, THREE, PLAY, OFFSET, HANGING, ON_ARM],
    ids=["rigid", "flexible", "cubic", "tool", "play", "offset", "elastic load", "third mass"],
)
def test_mujoco_moves_as_the_model_does(terms: tuple[str, ...]) -> None:
    pytest.importorskip("mujoco", reason="mujoco is not installed")
    model, record = driven(terms, ratio=None if terms in (RIGID, HANGING) else RATIO)
    found = Mujoco().hand_over(model)
    assert found.omitted == {}
    error = in_mujoco(found.text, model, record) - record.dphi_m
    assert np.sqrt(np.mean(error**2)) < SAME_MOTION * np.sqrt(np.mean(record.dphi_m**2))


def test_what_hangs_on_the_motor_of_a_flexible_joint_has_no_body_in_mujoco() -> None:
    assert set(Mujoco().omitted(handed((*ON_ARM, "motor.elastic_load")))) == {"link.third_mass", "motor.elastic_load"}


def test_an_elastic_load_is_a_body_behind_a_spring_in_mujoco() -> None:
    model = handed(HANGING, ratio=None)
    body = ET.fromstring(Mujoco().hand_over(model).text).find("worldbody/body")
    assert body is not None
    twist, inertial = body.findall("joint")[1], body.find("inertial")
    load = {name: model.fit[f"motor.elastic_load.{name}"].value for name in ("J", "w", "zeta")}
    assert float(twist.get("stiffness", "")) == pytest.approx(load["J"] * load["w"] ** 2)
    assert float(twist.get("damping", "")) == pytest.approx(2 * load["zeta"] * load["w"] * load["J"])
    assert inertial is not None
    assert inertial.get("diaginertia", "").split()[2] == repr(load["J"])


def test_an_elastic_load_moves_with_the_motor_in_urdf() -> None:
    model, _ = driven(HANGING, ratio=None)
    found = Urdf().hand_over(model)
    reduced = Urdf().reduced(model, found.omitted)
    assert set(found.omitted) == {"motor.elastic_load"}
    total = model.fit["motor.inertia.J"].value + model.fit["motor.elastic_load.J"].value
    assert reduced.fit["motor.inertia.J"].value == pytest.approx(total)
    (stated,) = found.costs
    (dropped,) = costs(model, model.without(found.omitted))
    assert stated.difference is not None
    assert dropped.difference is not None
    assert stated.difference < 0.5 * dropped.difference


def test_a_constant_torque_beyond_the_gear_has_no_actuator() -> None:
    assert set(Mujoco().omitted(handed((*FLEXIBLE, "arm.constant_torque")))) == {"arm.constant_torque"}
    assert set(Urdf().omitted(handed((*RIGID, "motor.constant_torque"), ratio=None))) == {"motor.constant_torque"}


def test_the_control_of_an_axis_that_slides_is_a_force() -> None:
    model = handed((*RIGID, "motor.constant_torque"), ratio=None)
    slides = replace(model, fit=replace(model.fit, structure=replace(model.fit.structure, linear=True)))
    assert Mujoco().remarks(slides) == (
        "The control is the force of the motor.",
        "The constant part is a bias of the actuator.",
    )


def test_what_mujoco_lacks_shows_as_the_cost_that_was_stated() -> None:
    pytest.importorskip("mujoco", reason="mujoco is not installed")
    model, record = driven((*FLEXIBLE, "motor.quadratic_friction", "motor.stribeck"))
    found = Mujoco().hand_over(replace(model, estimate_states=False))
    assert set(found.omitted) == {"motor.quadratic_friction", "motor.stribeck"}
    stated = found.costs[0].difference
    assert stated is not None
    error = in_mujoco(found.text, model, record) - record.dphi_m
    assert np.sqrt(np.mean(error**2)) == pytest.approx(stated, rel=0.05)


@pytest.mark.parametrize("terms", [FLEXIBLE, (*PLAY, "motor.stribeck"), (*THREE, "gear.hysteresis")])
def test_the_python_file_moves_as_the_model_does(terms: tuple[str, ...], tmp_path: Path) -> None:
    model, record = driven(terms, 0.6)
    names: dict[str, Any] = {}
    exec(PythonFunction().hand_over(model).text, names)
    x = names["simulate"](record.t, record.tau_m, names["first_state"]())
    error = x[:, names["STATES"].index("dphi_m")] - record.dphi_m
    assert np.sqrt(np.mean(error**2)) < 2e-3 * np.sqrt(np.mean(record.dphi_m**2))
    assert model.records[0].sampling_time == STEP
