"""Companions in a configuration: what effects read must be there, and of its kind."""

from __future__ import annotations

import pytest

from robotid.config.load import parse
from robotid.errors import ConfigError

TEXT = """robot:
  name: axis
  model: {motor: [inertia, %s]}
records:
  - name: day1
    file: day1.csv
    signals: {q2: {name: axis2, unit: deg, kind: angle}, oil: {name: T, kind: temperature}}
  - {name: day2, role: validate, file: day2.csv, signals: {%s}}
"""
BOTH = "q2: {name: axis2, kind: angle}, oil: {name: T, kind: temperature}"


def test_a_model_that_reads_a_companion() -> None:
    config = parse(TEXT % ('"pose_inertia[q2]", "temperature_friction[oil]"', BOTH))
    assert config.structure().terms == ("motor.inertia", "motor.pose_inertia[q2]", "motor.temperature_friction[oil]")
    assert config.records[0].signals["q2"].unit == "deg"


@pytest.mark.parametrize(
    ("effect", "second", "words"),
    [
        ("pose_inertia", BOTH, "pose_inertia reads a companion of kind angle; write pose_inertia[q2]"),
        ('"pose_inertia[q3]"', BOTH, 'no record has a signal "q3" of kind angle; write pose_inertia[q2]'),
        ('"pose_inertia[oil]"', BOTH, 'no record has a signal "oil" of kind angle'),
        ('"known_torque[push]"', BOTH, "add one of kind torque to signals of the records"),
        ('"coulomb[q2]"', BOTH, "coulomb reads no companion; write coulomb"),
        ('"pose_inertia[q2]"', "oil: {name: T, kind: temperature}", "day2 has no signal q2; add q2 to its signals"),
        ("viscous", "phi_m: {name: T, kind: temperature}", "phi_m is the name of a column of the joint itself"),
        ("viscous", "oil: {name: T, kind: heat}", "kind"),
    ],
)
def test_what_does_not_fit_is_refused(effect: str, second: str, words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse(TEXT % (effect, second))
    assert words in str(caught.value)
