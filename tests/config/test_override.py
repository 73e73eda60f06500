"""--set reaches every place of a configuration, also those that are not written yet."""

from __future__ import annotations

import pytest

from robotid.config.load import parse
from robotid.errors import ConfigError

TEXT = """\
robot:
  name: axis
  gear_ratio: 0.01
  model: {motor: [inertia, coulomb], gear: [spring], arm: [inertia]}
records:
  - {name: day1, file: day1.csv}
  - {name: day2, file: day2.csv}
validate:
"""


def test_a_value() -> None:
    assert parse(TEXT, overrides=["robot.gear_ratio=0.02"]).robot.gear_ratio == 0.02


def test_the_last_word_counts() -> None:
    assert parse(TEXT, overrides=["robot.gear_ratio=0.02", "robot.gear_ratio=0.03"]).robot.gear_ratio == 0.03


@pytest.mark.parametrize("place", ["records.day2", "records.1", "records[1]"])
def test_a_record_by_name_or_index(place: str) -> None:
    config = parse(TEXT, overrides=[f"{place}.role=validate"])
    assert [r.role for r in config.records] == ["estimate", "validate"]


def test_a_whole_list_and_one_entry_of_it() -> None:
    config = parse(TEXT, overrides=["robot.model.motor=[inertia, viscous]", "robot.model.motor[1]=stribeck"])
    assert config.robot.model["motor"] == ("inertia", "stribeck")


def test_a_section_that_is_not_there_or_empty() -> None:
    config = parse(TEXT, overrides=["fit.models.m1=[day1]", "validate.perturbation=10"])
    assert config.fit.models == {"m1": ("day1",)}
    assert config.validation.perturbation == 10


def test_a_parameters_dots_are_not_sections() -> None:
    changes = ["robot.parameters.gear.spring.k1.guess=2e6", "robot.parameters.gear.spring.k1.fixed=true"]
    settings = parse(TEXT, overrides=changes).robot.parameters["gear.spring.k1"]
    assert (settings.guess, settings.fixed) == (2e6, True)


def test_nothing_is_null() -> None:
    assert parse(TEXT, overrides=["init_rigid.cutoff=5", "init_rigid.cutoff="]).init_rigid.cutoff is None


def test_an_aliased_block_changes_in_one_place_only() -> None:
    text = TEXT.replace("- {name: day1,", "- &first {name: day1,").replace("{name: day2,", "{<<: *first, name: day2,")
    config = parse(text, overrides=["records.day2.file=other.csv"])
    assert [r.file for r in config.records] == ["day1.csv", "other.csv"]


def test_an_entry_beyond_the_end() -> None:
    with pytest.raises(ConfigError) as caught:
        parse(TEXT, overrides=["records[7].role=validate"])
    expected = '--set records[7].role=validate: records has 2 entries and none of them is "7"; one of day1, day2'
    assert str(caught.value) == expected
