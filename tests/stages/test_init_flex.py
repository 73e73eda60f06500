"""Stage init-flex: which records and what prior knowledge it takes from the configuration."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from support.paper_joint import TRUTH
from support.virtual_records import configured, recordings, true_records

from robotid.estimate.rigid import RigidResult
from robotid.stages.init_flex import init_flex
from robotid.stages.init_rigid import init_rigid

RIGID = {"motor": ("inertia", "viscous", "coulomb")}


@cache
def rigid() -> RigidResult:
    return init_rigid(configured(), recordings())


def test_the_start_of_the_paper_joint() -> None:
    guesses = rigid().guesses | init_flex(configured(), recordings(), rigid()).guesses
    for name in ("motor.inertia.J", "arm.inertia.J", "gear.spring.k1", "motor.viscous.Fv", "motor.coulomb.Fc"):
        assert guesses[name] == pytest.approx(TRUTH[name], rel=0.05)


def test_only_records_of_its_use_and_role_count() -> None:
    set1, set2, set3 = true_records()
    result = init_flex(configured(), recordings(set1, set2, replace(set3, role="validate")), rigid())
    assert [frf.record for frf in result.frfs] == ["set2"]


def test_the_band_reaches_the_responses() -> None:
    result = init_flex(configured(init_flex={"band": (2.0, 30.0)}), recordings(), rigid())
    assert [frf.frequency[[0, -1]].tolist() for frf in result.frfs] == [pytest.approx([2.0, 30.0])] * 2


def test_the_window_widens_the_neighbourhood() -> None:
    fine, coarse = (init_flex(configured(init_flex={"window": w}), recordings(), rigid()).frfs[0] for w in (5.0, 1.0))
    notch = 5.7
    assert abs(coarse.response[abs(coarse.frequency - notch).argmin()]) > abs(
        fine.response[abs(fine.frequency - notch).argmin()]
    )


def test_a_fixed_stiffness_is_held() -> None:
    known = {"gear.spring.k1": {"guess": 1.5e6, "fixed": True}}
    result = init_flex(configured(robot={"parameters": known}), recordings(), rigid())
    assert result.readings[0].values["gear.spring.k1"] == 1.5e6
    assert "gear.spring.k1" not in {estimate.name for estimate in result.parameters}


def test_a_rigid_axis_has_an_empty_result() -> None:
    result = init_flex(configured(RIGID), recordings(), init_rigid(configured(RIGID), recordings()))
    assert result.guesses == {}
    assert "rigid axis" in result.remarks[0]


def test_without_records_for_it_the_result_says_so() -> None:
    result = init_flex(configured(), recordings(true_records()[0]), rigid())
    assert result.frfs == ()
    assert "no record" in result.remarks[0]
