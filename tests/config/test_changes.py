"""Parameters that differ between records, as a configuration names them."""

from __future__ import annotations

import pytest

from robotid.catalogue import assemble
from robotid.config.load import parse, resolved
from robotid.errors import ConfigError
from robotid.model.structure import change
from robotid.stages.ingestion.virtual import virtual_robot

MEASURED = """\
robot:
  name: arm
  gear_ratio: 0.01
  model: {motor: [inertia, viscous, coulomb], gear: [spring, damper], arm: [inertia]}
  changes:
    day2: [arm.inertia.J, motor.coulomb.Fc]
    day3: [arm.inertia.J]
  parameters:
    record_change.day2.arm.inertia.J: {guess: -5, bounds: [-20, 0]}
records:
  - {name: day1, file: day1.csv}
  - {name: day2, file: day2.csv}
  - {name: day3, role: validate, file: day3.csv}
"""
VIRTUAL = """\
robot: {name: axis, model: {motor: [inertia, coulomb]}, changes: {wave_r2: [motor.coulomb.Fc]}}
records:
  - name: wave
    excite: {kind: multisine, band: [1, 10], period: 1, peak: 2, sampling_time: 0.01, realisations: 3}
plant:
  parameters: {motor.inertia.J: 0.01, motor.coulomb.Fc: 0.5}
  controller: {kind: speed, kp: 1}
"""


def test_changes_are_effects_of_the_model_in_the_order_given() -> None:
    structure = parse(MEASURED).structure()
    expected = (("day2", "arm.inertia.J"), ("day2", "motor.coulomb.Fc"), ("day3", "arm.inertia.J"))
    assert structure.changes == tuple(change(*one) for one in expected)
    assert structure.effects[-3:] == structure.changes


def test_a_change_may_go_either_way_whatever_its_parameter_may() -> None:
    """An inertia is positive; what is taken off it is not."""
    settings = parse(MEASURED).robot.parameters["record_change.day2.arm.inertia.J"]
    assert (settings.guess, settings.bounds) == (-5, (-20, 0))
    joint = assemble(parse(MEASURED).structure())
    k = joint.names.index("record_change.day3.arm.inertia.J")
    declared = joint.parameters()
    assert (declared.values[k], declared.lower[k], declared.upper[k]) == (0.0, -float("inf"), float("inf"))


def test_the_dots_of_a_change_are_not_sections() -> None:
    config = parse(MEASURED, overrides=["robot.parameters.record_change.day3.arm.inertia.J.guess=7"])
    assert config.robot.parameters["record_change.day3.arm.inertia.J"].guess == 7
    assert config.robot.parameters["record_change.day2.arm.inertia.J"].guess == -5


def test_a_resolved_configuration_says_the_same() -> None:
    config = parse(MEASURED)
    assert parse(resolved(config)).structure() == config.structure()
    assert parse(resolved(config)).robot.changes == config.robot.changes


def test_a_realisation_is_a_record_that_may_differ() -> None:
    assert parse(VIRTUAL).structure().changes == (change("wave_r2", "motor.coulomb.Fc"),)


def test_the_virtual_robot_is_the_same_in_every_record() -> None:
    config = parse(VIRTUAL)
    assert config.plant_structure().changes == ()
    assert virtual_robot(config).joint.names == ("motor.inertia.J", "motor.coulomb.Fc")
    with pytest.raises(
        ConfigError, match=r'the virtual robot has no parameter "record_change\.wave_r2\.motor\.coulomb\.Fc"'
    ):
        parse(VIRTUAL, overrides=["plant.parameters.record_change.wave_r2.motor.coulomb.Fc=0.1"])


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ("{day4: [arm.inertia.J]}", r'robot.changes.day4: there is no record "day4"; did you mean day'),
        ("{day2: [arm.viscous.Fv]}", r'robot.changes.day2\[0\]: the model has no parameter "arm.viscous.Fv"'),
        ("{day2: [gear.spring]}", r'"gear.spring"; did you mean gear.spring.k1\?'),
        ("{day2: [arm.inertia.J, arm.inertia.J]}", r"robot.changes.day2\[1\]: arm.inertia.J is listed twice"),
        ("{day2: [record_change.day3.arm.inertia.J]}", r'has no parameter "record_change.day3.arm.inertia.J"'),
    ],
)
def test_what_cannot_differ_is_told_with_its_place(changes: str, what: str) -> None:
    with pytest.raises(ConfigError, match=what):
        parse(MEASURED, overrides=[f"robot.changes={changes}"])


def test_a_change_of_an_effect_that_is_taken_away_is_told() -> None:
    with pytest.raises(ConfigError, match=r'robot.changes.day2\[1\]: the model has no parameter "motor.coulomb.Fc"'):
        parse(MEASURED, overrides=["robot.model.motor=[inertia, viscous]"])
