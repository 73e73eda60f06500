"""Stage init-rigid: which records and what prior knowledge it takes from the configuration."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.paper_joint import RATIO
from support.virtual_records import configured, recordings, true_records

from robotid.errors import NumericsError
from robotid.stages.init_rigid import init_rigid


def test_only_records_of_its_use_and_role_count() -> None:
    set1, set2, _ = true_records()
    held_out = replace(set1, name="held_out", role="validate")
    result = init_rigid(configured(), recordings(set1, set2, held_out))
    assert set(result.torque_error_percent) == {"set1"}


def test_the_rigid_joint_of_the_paper() -> None:
    result = init_rigid(configured(), recordings())
    assert result["joint.inertia.J"].value == pytest.approx(0.0121 + RATIO**2 * 1130, rel=0.02)
    assert result["motor.viscous.Fv"].value == pytest.approx(0.013, rel=0.02)
    assert result["motor.coulomb.Fc"].value == pytest.approx(0.644, rel=0.02)
    assert result.torque_error_percent["set1"] < 2


def test_settings_reach_the_filter() -> None:
    result = init_rigid(configured(init_rigid={"cutoff": 3.0}), recordings())
    assert result.cutoff == {"set1": 3.0}


def test_what_is_fixed_to_a_guess_is_held_and_what_is_only_fixed_is_estimated() -> None:
    known = {"motor.inertia.J": {"guess": 0.0121, "fixed": True}, "motor.viscous.Fv": {"fixed": True}}
    result = init_rigid(configured(robot={"parameters": known}), recordings())
    assert [p.name for p in result.parameters] == ["motor.viscous.Fv", "motor.coulomb.Fc", "arm.inertia.J"]
    assert result["arm.inertia.J"].value == pytest.approx(1130, rel=0.02)


def test_no_record_for_it_is_refused() -> None:
    with pytest.raises(NumericsError, match="no record serves the rigid initialisation"):
        init_rigid(configured(), recordings(*true_records()[1:]))
