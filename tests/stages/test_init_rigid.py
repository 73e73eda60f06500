"""Stage init-rigid: which records and what prior knowledge it takes from the configuration."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from paper_joint import RATIO, STRUCTURE, TRUTH
from virtual_records import paper_records

from robotid.config.schema import Config
from robotid.errors import NumericsError
from robotid.signals.quality import Recordings
from robotid.signals.record import Record
from robotid.stages.init_rigid import init_rigid

MODEL = {
    "motor": ["inertia", "viscous", "coulomb"],
    "gear": ["spring", "cubic_spring", "damper"],
    "arm": ["inertia"],
}


@cache
def records() -> tuple[Record, ...]:
    return paper_records(STRUCTURE, TRUTH)


def config(**sections: Any) -> Config:
    robot = {"name": "irb", "gear_ratio": RATIO, "model": {k: tuple(v) for k, v in MODEL.items()}}
    robot |= sections.pop("robot", {})
    return Config.model_validate({"robot": robot, "records": ({"name": "set1", "file": "set1.csv"},), **sections})


def recordings(*chosen: Record) -> Recordings:
    return Recordings(records=chosen or records(), reports=())


def test_only_records_of_its_use_and_role_count() -> None:
    set1, set2, _ = records()
    held_out = replace(set1, name="held_out", role="validate")
    result = init_rigid(config(), recordings(set1, set2, held_out))
    assert set(result.torque_error_percent) == {"set1"}


def test_the_rigid_joint_of_the_paper() -> None:
    result = init_rigid(config(), recordings())
    assert result["joint.inertia.J"].value == pytest.approx(0.0121 + RATIO**2 * 1130, rel=0.02)
    assert result["motor.viscous.Fv"].value == pytest.approx(0.013, rel=0.02)
    assert result["motor.coulomb.Fc"].value == pytest.approx(0.644, rel=0.02)
    assert result.torque_error_percent["set1"] < 2


def test_settings_reach_the_filter() -> None:
    result = init_rigid(config(init_rigid={"cutoff": 3.0}), recordings())
    assert result.cutoff == {"set1": 3.0}


def test_what_is_fixed_to_a_guess_is_held_and_what_is_only_fixed_is_estimated() -> None:
    known = {"motor.inertia.J": {"guess": 0.0121, "fixed": True}, "motor.viscous.Fv": {"fixed": True}}
    result = init_rigid(config(robot={"parameters": known}), recordings())
    assert [p.name for p in result.parameters] == ["motor.viscous.Fv", "motor.coulomb.Fc", "arm.inertia.J"]
    assert result["arm.inertia.J"].value == pytest.approx(1130, rel=0.02)


def test_no_record_for_it_is_refused() -> None:
    with pytest.raises(NumericsError, match="no record serves the rigid initialisation"):
        init_rigid(config(), recordings(*records()[1:]))
