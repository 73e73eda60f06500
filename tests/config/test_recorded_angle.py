"""Torques at the recorded angle, as a configuration asks for them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from robotid.config.extended import extended_text
from robotid.config.load import load, parse
from robotid.errors import ConfigError

AXIS = """\
robot: {name: axis, model: {motor: [inertia, coulomb, cogging]}}
records:
  - {name: day1, file: day1.csv}
"""


def test_a_configuration_asks_for_the_recorded_angle() -> None:
    assert not parse(AXIS).structure().recorded_angle
    assert parse(AXIS, overrides=["robot.recorded_angle=true"]).structure().recorded_angle


def test_anything_but_true_or_false_is_refused() -> None:
    with pytest.raises(ConfigError, match="recorded_angle"):
        parse(AXIS, overrides=["robot.recorded_angle=measured"])


@pytest.mark.parametrize("recorded", [False, True])
def test_an_extended_configuration_keeps_it(recorded: bool, tmp_path: Path) -> None:
    (tmp_path / "axis.yaml").write_text(AXIS, encoding="utf-8")
    loaded = load(tmp_path / "axis.yaml")
    structure = replace(loaded.config.structure(), recorded_angle=recorded)
    text = extended_text(loaded, structure, {"motor.cogging.n": 7.0}, tmp_path, late=0.0)
    assert parse(text).structure() == structure
