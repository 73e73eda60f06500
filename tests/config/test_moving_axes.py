"""The configuration of a virtual robot whose axes move together."""

from __future__ import annotations

import pytest
from support.moving_axes import THREE, TWO

from robotid.config.load import parse, parse_axes, resolved
from robotid.errors import ConfigError

PLAIN = "{motor: [inertia, viscous, coulomb], gear: [spring, damper], arm: [inertia]}"


def test_every_axis_knows_what_moves_the_others() -> None:
    first, second = parse_axes(TWO).values()
    assert first.plant is not None
    assert second.plant is not None
    body = first.plant.body
    assert body is not None
    assert (body.axis, body.axes, list(body.others)) == ("a1", ("a1", "a2"), ["a2"])
    assert body.others["a2"].parameters == second.plant.parameters
    assert body.others["a2"].controller.kp == 0.03
    assert (body.others["a2"].gear_ratio, body.others["a2"].seed) == (0.0125, 3)
    assert body.others["a2"].model == second.robot.model
    assert first.records[1].others["a2"] == second.records[1].excite
    assert first.records[0].pose == second.records[0].pose == {"a2": 0.5}


def test_keys_of_an_axis_stand_for_those_of_the_record() -> None:
    first, second = (axis.records[1].excite for axis in parse_axes(TWO).values())
    assert first is not None
    assert second is not None
    assert [one.parts[0].peak for one in (first, second)] == [20.0, 25.0]
    assert [one.parts[0].band for one in (first, second)] == [(5.0, 30.0), (5.0, 40.0)]


def test_an_axis_may_follow_another_kind_of_wave() -> None:
    text = TWO.replace("a2: {peak: 25, band: [5, 40]}", "a2: {kind: square, amplitude: 5, period: 0.2, duration: 0.4}")
    other = parse_axes(text)["a1"].records[1].others["a2"]
    assert (other.kind, other.sampling_time, other.samples) == ("square", 0.001, 400)


def test_an_axis_is_a_complete_configuration() -> None:
    config = parse_axes(TWO)["a2"]
    assert parse(resolved(config)) == config


def test_the_angles_of_the_others_are_companions() -> None:
    text = TWO.replace("arm: [inertia]}\n      plant", 'arm: [inertia, "pose_lever[a2]"]}\n      plant', 1)
    text = text.replace("model: *joint", f"model: {PLAIN}")
    with pytest.raises(ConfigError, match=r"arm\[1\].*cannot have pose_lever\[a2\]: plant.body .*under plant.model"):
        parse_axes(text)
    own = f"      plant:\n        model: {PLAIN}\n"
    config = parse_axes(text.replace("      plant:\n", own, 1))["a1"]
    assert "arm.pose_lever[a2]" in config.structure().terms
    assert "arm.pose_lever[a2]" not in config.plant_structure().terms


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        (", {mass: 10, centre: 0.2, inertia: 0.2}]", "]", r"cfg:45  plant\.body", "1 links for 2 axes"),
        ("mass: 20", "mas: 20", r"cfg:45  plant\.body\.links\[0\]\.mas", "did you mean mass"),
        ("pose: {a2: 0.5}", "pose: {a3: 0.5}", r"cfg:30  records\[0\]\.pose\.a3", 'no axis "a3"'),
        ("a1: {peak: 20}", "a3: {peak: 20}", r"cfg:42  records\[1\]\.excite\.axes", 'no axis "a3"'),
        (
            "axes: {a1: {amplitude: 20}, a2: {amplitude: 25}}",
            "axes: 3",
            r"cfg:32  records\[0\]\.excite\.axes",
            "by name",
        ),
        ("a2: {peak: 25,", "a2: {peak: 25, period: 0.6,", r"cfg:43  records\[1\]\.excite", "for 0.6 s .* for 0.4 s"),
        (
            "a2: {peak: 25,",
            "a2: {peak: 25, sampling_time: 0.002,",
            r"cfg:43  records\[1\]",
            "sampling times of 0.002 and",
        ),
        ("a2: {peak: 25,", "a2: {peak: 25, realisations: 2,", r"cfg:43  records\[1\]", "numbers of realisations"),
        ("      gear_ratio: 0.0125\n", "", r"cfg:16  robot\.axes\.a2", "no gear_ratio"),
        ("gear_ratio: 0.0125", "linear: true", r"cfg:16  robot\.axes\.a2", "axis a2 slides"),
        (
            "          gear.damper.d: 10\n",
            "",
            r"cfg:20  robot\.axes\.a2\.plant\.parameters",
            '"gear.damper.d" is missing',
        ),
        (
            "gear.damper.d: 10",
            "gear.damper.d: -10",
            r"cfg:25  robot\.axes\.a2\.plant\.parameters",
            "outside the bounds",
        ),
        ("    a2:\n", "    a2:\n      plant: {body: {}}\n", r"cfg:20", "stands twice"),
        (
            "kp: 0.03, ki: 0.3}\n",
            "kp: 0.03}\n        body: {}\n",
            r"cfg:28  robot\.axes\.a2\.plant\.body",
            "couples all axes",
        ),
        ("  body: {links", "  bdy: {links", r"cfg:45  plant\.bdy", "did you mean body"),
        ("peak: 20}", "peak: 20, orthogonal: true}", r"cfg:36  records\[1\]\.excite", "take as many experiments"),
    ],
)
def test_an_error_names_the_line_and_the_key(old: str, new: str, where: str, what: str) -> None:
    assert old in TWO
    with pytest.raises(ConfigError, match=rf"^{where}.*{what}"):
        parse_axes(TWO.replace(old, new), "cfg")


def test_orthogonal_multisines_have_the_same_lines() -> None:
    several = TWO.replace("period: 0.4\n", "period: 0.4\n      realisations: 2\n      orthogonal: true\n")
    with pytest.raises(ConfigError, match=r"axis a2 is not excited at the same frequencies"):
        parse_axes(several)
    assert parse_axes(several.replace("band: [5, 40]", "band: [5, 30]"))["a1"].records[1].excite is not None
    with pytest.raises(ConfigError, match="orthogonal multisines of 3 axes"):
        parse_axes(THREE.replace("realisations: 3", "realisations: 2"))


def test_nothing_couples_a_single_joint() -> None:
    single = resolved(parse_axes(TWO)["a1"]).replace("  body:", "  bdy:")
    with pytest.raises(ConfigError, match="bdy"):
        parse(single)
    uncoupled = TWO.replace(TWO[TWO.index("  body:") : TWO.index("  seed:")], "")
    with pytest.raises(ConfigError, match=r"records\[0\]\.pose.*nothing couples this joint"):
        parse_axes(uncoupled)
    apart = parse_axes(uncoupled.replace("    pose: {a2: 0.5}\n", ""))
    assert [axis.records[0].others for axis in apart.values()] == [{}, {}]
