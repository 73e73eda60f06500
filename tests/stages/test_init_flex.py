"""Stage init-flex: which records and what prior knowledge it takes from the configuration."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from paper_joint import RATIO, STRUCTURE, TRUTH
from virtual_records import paper_records

from robotid.config.schema import Config
from robotid.estimate.rigid import RigidResult
from robotid.signals.quality import Recordings
from robotid.signals.record import Record
from robotid.stages.init_flex import init_flex
from robotid.stages.init_rigid import init_rigid

TWO_MASSES = {
    "motor": ("inertia", "viscous", "coulomb"),
    "gear": ("spring", "cubic_spring", "damper"),
    "arm": ("inertia",),
}
RIGID = {"motor": ("inertia", "viscous", "coulomb")}


def config(model: dict[str, tuple[str, ...]] = TWO_MASSES, **sections: Any) -> Config:
    robot = {"name": "irb", "gear_ratio": RATIO, "model": model} | sections.pop("robot", {})
    return Config.model_validate({"robot": robot, "records": ({"name": "set1", "file": "set1.csv"},), **sections})


@cache
def records() -> tuple[Record, ...]:
    return paper_records(STRUCTURE, TRUTH)


@cache
def rigid() -> RigidResult:
    return init_rigid(config(), recordings())


def recordings(*chosen: Record) -> Recordings:
    return Recordings(records=chosen or records(), reports=())


def test_the_start_of_the_paper_joint() -> None:
    guesses = rigid().guesses | init_flex(config(), recordings(), rigid()).guesses
    for name in ("motor.inertia.J", "arm.inertia.J", "gear.spring.k1", "motor.viscous.Fv", "motor.coulomb.Fc"):
        assert guesses[name] == pytest.approx(TRUTH[name], rel=0.05)


def test_only_records_of_its_use_and_role_count() -> None:
    set1, set2, set3 = records()
    result = init_flex(config(), recordings(set1, set2, replace(set3, role="validate")), rigid())
    assert [frf.record for frf in result.frfs] == ["set2"]


def test_the_band_reaches_the_responses() -> None:
    result = init_flex(config(init_flex={"band": (2.0, 30.0)}), recordings(), rigid())
    assert [frf.frequency[[0, -1]].tolist() for frf in result.frfs] == [pytest.approx([2.0, 30.0])] * 2


def test_the_window_widens_the_neighbourhood() -> None:
    fine, coarse = (init_flex(config(init_flex={"window": w}), recordings(), rigid()).frfs[0] for w in (5.0, 1.0))
    notch = 5.7
    assert abs(coarse.response[abs(coarse.frequency - notch).argmin()]) > abs(
        fine.response[abs(fine.frequency - notch).argmin()]
    )


def test_a_fixed_stiffness_is_held() -> None:
    known = {"gear.spring.k1": {"guess": 1.5e6, "fixed": True}}
    result = init_flex(config(robot={"parameters": known}), recordings(), rigid())
    assert result.readings[0].values["gear.spring.k1"] == 1.5e6
    assert "gear.spring.k1" not in {estimate.name for estimate in result.parameters}


def test_a_rigid_axis_has_an_empty_result() -> None:
    result = init_flex(config(RIGID), recordings(), init_rigid(config(RIGID), recordings()))
    assert result.guesses == {}
    assert "rigid axis" in result.remarks[0]


def test_without_records_for_it_the_result_says_so() -> None:
    result = init_flex(config(), recordings(records()[0]), rigid())
    assert result.frfs == ()
    assert "no record" in result.remarks[0]
