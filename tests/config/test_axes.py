"""A robot of several axes is split into configurations of one joint."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotid.config.load import load, load_robot, parse, parse_axes, resolved
from robotid.errors import ConfigError

ROBOT = """\
robot:
  name: arm
  axes:
    a1:
      gear_ratio: 0.01
      model: {motor: [inertia, viscous, coulomb, "pose_lever[a2]"]}
      parameters:
        motor.inertia.J: {guess: 0.02}
      columns: {tau_m: torque_1, phi_m: angle_1}
    a2:
      gear_ratio: -0.02
      model: {motor: [inertia, viscous]}
      columns:
        tau_m: {name: torque_2, unit: Nm}
        phi_m: {name: counts, column: 1, unit: deg, scale: 4.0, offset: 1.0}
        dphi_m: null
      fit: {max_iterations: 7}
records:
  - name: day1
    file: day1.csv
    columns: {t: time, dphi_m: speed}
    signals: {hot: {name: T, unit: degC, kind: temperature}}
  - {name: day2, role: validate, file: day2.csv, columns: {t: time}}
fit: {tolerance: 1.0e-7}
"""


def test_each_axis_is_a_joint_of_its_own() -> None:
    axes = parse_axes(ROBOT)
    assert list(axes) == ["a1", "a2"]
    assert [axis.robot.name for axis in axes.values()] == ["arm_a1", "arm_a2"]
    assert axes["a1"].robot.gear_ratio == 0.01
    assert axes["a1"].robot.parameters["motor.inertia.J"].guess == 0.02
    assert axes["a2"].robot.parameters == {}


def test_columns_of_an_axis_stand_over_those_of_the_record() -> None:
    first, second = (axis.records[0].columns for axis in parse_axes(ROBOT).values())
    assert (first.t, first.tau_m, first.phi_m, first.dphi_m) == ("time", "torque_1", "angle_1", "speed")
    assert (second.t, second.tau_m.name, second.dphi_m) == ("time", "torque_2", None)
    assert "dphi_m" in second.model_fields_set


def test_the_angle_of_another_axis_is_a_companion_behind_its_gear() -> None:
    axes = parse_axes(ROBOT)
    seen = axes["a1"].records[1].signals["a2"]
    assert (seen.name, seen.column, seen.unit, seen.kind) == ("counts", 1, "deg", "angle")
    assert (seen.scale, seen.offset) == (-0.08, -0.02)
    assert axes["a2"].records[1].signals["a1"].scale == 0.01
    assert list(axes["a1"].records[0].signals) == ["a2", "hot"]


def test_an_axis_states_under_which_angle_others_see_it() -> None:
    axes = parse_axes(ROBOT, overrides=["robot.axes.a2.angle={name: joint_2, unit: deg}"])
    assert axes["a1"].records[0].signals["a2"].name == "joint_2"
    assert axes["a1"].records[0].signals["a2"].scale is None
    text = ROBOT.replace(', "pose_lever[a2]"', "").replace("gear_ratio: -0.02", "angle: null")
    assert "a2" not in parse_axes(text)["a1"].records[0].signals


def test_the_signal_of_a_record_stands_for_the_angle_of_that_axis() -> None:
    other = "records.day1.signals.a2={name: q2, unit: rad, kind: angle}"
    axes = parse_axes(ROBOT, overrides=[other])
    assert axes["a1"].records[0].signals["a2"].name == "q2"
    assert "a2" not in axes["a2"].records[0].signals


def test_a_section_of_an_axis_stands_over_that_of_the_robot() -> None:
    axes = parse_axes(ROBOT)
    assert [axis.fit.tolerance for axis in axes.values()] == [1e-7, 1e-7]
    assert [axis.fit.max_iterations for axis in axes.values()] == [50, 7]
    former = ROBOT.replace("fit: {max_iterations: 7}", "diagnose: {worth: 0.3}") + "diagnose: {level: 1.0e-4}\n"
    section = parse_axes(former)["a2"].diagnose
    assert (section.min_improvement_sigma, section.significance) == (0.3, 1e-4)


def test_the_body_of_the_robot_gets_the_signals_of_all_axes() -> None:
    body = "  body: {dh: [{d: 0.5}, {a: 0.4}], rotors: {a2: 0.01}}\nrecords:"
    axes = parse_axes(ROBOT.replace("records:", body))
    first = axes["a1"].robot.body
    assert (first.axis, list(first.axes), first.rotors) == ("a1", ["a1", "a2"], {"a2": 0.01})
    assert (first.axes["a1"].angle, first.axes["a1"].gear_ratio) == (None, 0.01)
    assert (first.axes["a2"].angle, first.axes["a2"].torque, first.axes["a2"].gear_ratio) == ("a2", "tau_a2", -0.02)
    signal = axes["a1"].records[0].signals["tau_a2"]
    assert (signal.name, signal.unit, signal.kind) == ("torque_2", "Nm", "drive")
    with pytest.raises(ConfigError, match=r"^cfg:18  robot\.body\.dhh.*did you mean dh"):
        parse_axes(ROBOT.replace("records:", body.replace("dh:", "dhh:")), "cfg")


def test_an_axis_is_a_complete_configuration() -> None:
    config = parse_axes(ROBOT)["a1"]
    assert parse(resolved(config)) == config


def test_set_reaches_the_parameters_of_an_axis() -> None:
    changed = parse_axes(ROBOT, overrides=["robot.axes.a2.parameters.motor.viscous.Fv.guess=0.5"])
    assert changed["a2"].robot.parameters["motor.viscous.Fv"].guess == 0.5


def test_a_single_joint_has_one_axis_without_a_name(tmp_path: Path) -> None:
    file = tmp_path / "joint.yaml"
    file.write_text(resolved(parse_axes(ROBOT)["a1"]))
    robot = load_robot(file)
    assert robot == {"": load(file)}
    with pytest.raises(ConfigError, match="this robot has a single joint"):
        load(file, axis="a1")


def test_one_axis_is_loaded_by_its_name(tmp_path: Path) -> None:
    file = tmp_path / "arm.yaml"
    file.write_text(ROBOT)
    assert load(file, axis="a2").config == parse_axes(ROBOT)["a2"]
    assert load(file, axis="a2").axis == "a2"
    with pytest.raises(ConfigError, match="this robot has several axes: a1, a2"):
        load(file)
    with pytest.raises(ConfigError, match='there is no axis "b2"; one of a1, a2'):
        load(file, axis="b2")


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ("  name: arm\n", "  name: arm\n  gear_ratio: 0.1\n", r"cfg:3  robot\.gear_ratio", "gear_ratio is of one axis"),
        ("  name: arm\n", "  name: arm\n  nmae: 1\n", r"cfg:3  robot\.nmae", 'no key "nmae".*did you mean name'),
        ("  name: arm\n", "", "cfg:2  robot", '"name" is missing'),
        ("gear_ratio: -0.02", "gear_ration: 2", r"cfg:11  robot\.axes\.a2\.gear_ration", "did you mean gear_ratio"),
        ("[inertia, viscous]", "[inertia, viscos]", r"cfg:12  robot\.axes\.a2\.model\.motor\[1\]", '"viscos"'),
        ("fit: {max_iterations: 7}", "fit: {max_iteration: 7}", r"cfg:17  robot\.axes\.a2\.fit", "did you mean"),
        ("tau_m: torque_1, ", "", r"cfg:9  robot\.axes\.a1\.columns", "axis a1 has no column for tau_m"),
        ("tau_m: torque_1", "tau: torque_1", r"cfg:9  robot\.axes\.a1\.columns", "no column for tau_m"),
        ("column: 1", "column: -1", r"cfg:15  robot\.axes\.a2\.columns\.phi_m\.column", "at least 0"),
        ("pose_lever[a2]", "pose_lever[a3]", r"cfg:6  robot\.axes\.a1\.model\.motor\[3\]", r"pose_lever\[a2\]"),
        ("      fit: {max", "      name: x\n      fit: {max", r"cfg:17  robot\.axes\.a2", "name is of the robot"),
        ("    a1:\n", "    a 1:\n", "cfg:4", "a name has letters"),
        ("role: validate", "role: valid", r"cfg:23  records\[1\]\.role", "validate"),
    ],
)
def test_an_error_names_the_line_and_the_key_of_the_axis(old: str, new: str, where: str, what: str) -> None:
    assert old in ROBOT
    with pytest.raises(ConfigError, match=rf"^{where}.*{what}"):
        parse_axes(ROBOT.replace(old, new), "cfg")


@pytest.mark.parametrize("axes", ["{}", "[]", "3", "{a1: 3}", "{a1: }"])
def test_axes_are_mappings(axes: str) -> None:
    text = f"robot:\n  name: arm\n  axes: {axes}\nrecords: [{{name: a, file: a.csv}}]\n"
    with pytest.raises(ConfigError, match=r"^cfg:3  robot\.axes.*such as"):
        parse_axes(text, "cfg")
