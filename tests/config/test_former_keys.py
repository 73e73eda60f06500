"""Keys of earlier versions mean what the current ones mean."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotid.config.former_keys import former_keys
from robotid.config.load import Loaded, load, parse
from robotid.config.schema import Config
from robotid.errors import ConfigError

TEXT = """\
robot: {name: axis, model: {motor: [inertia, viscous]}}
records:
  - {name: day1, file: day1.csv}
"""
FORMER = TEXT + "diagnose:\n  level: 0.01\n  worth: 0.2\n  causes: 2\n  refits: 3\n"
CURRENT = TEXT + "diagnose:\n  significance: 0.01\n  min_improvement_sigma: 0.2\n  max_causes: 2\n  max_refits: 3\n"


def loaded(text: str, folder: Path) -> Loaded:
    (folder / "axis.yaml").write_text(text)
    return load(folder / "axis.yaml")


def test_both_are_the_same_configuration(tmp_path: Path) -> None:
    former, current = loaded(FORMER, tmp_path), loaded(CURRENT, tmp_path)
    assert former.config == current.config
    assert former.config.diagnose.min_improvement_sigma == 0.2
    assert former.section_text("diagnose") == current.section_text("diagnose")
    assert former.resolved_text() == current.resolved_text()


@pytest.mark.parametrize("text", [TEXT, FORMER, CURRENT])
@pytest.mark.parametrize(
    "option", ["diagnose.worth=0.7", "diagnose.min_improvement_sigma=0.7", "diagnose={worth: 0.7}"]
)
def test_an_option_may_use_either(text: str, option: str) -> None:
    assert parse(text, overrides=[option]).diagnose.min_improvement_sigma == 0.7


def test_both_at_once_are_an_error_at_the_former_one() -> None:
    with pytest.raises(ConfigError) as caught:
        parse(CURRENT + "  worth: 0.3\n", "a.yaml")
    assert str(caught.value) == (
        'a.yaml:9  diagnose.worth: "worth" is the former name of min_improvement_sigma, '
        "and both are given; remove worth"
    )


def test_a_wrong_value_is_found_on_the_line_of_the_former_key() -> None:
    with pytest.raises(ConfigError, match=r"^a\.yaml:5  diagnose\.significance: must be less than 1, found 2"):
        parse(FORMER.replace("0.01", "2"), "a.yaml")


@pytest.mark.parametrize(("section", "renamed"), former_keys().items())
def test_former_keys_lead_to_keys_that_exist(section: str, renamed: dict[str, str]) -> None:
    field = next(field for name, field in Config.model_fields.items() if (field.alias or name) == section)
    known = field.annotation.model_fields.keys()  # type: ignore[union-attr]
    assert set(renamed.values()) <= known
    assert not renamed.keys() & known
