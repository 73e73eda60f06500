"""Which effects of the catalogue a model could lack."""

from __future__ import annotations

import pytest

from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.model.structure import Structure

AXIS = ("motor.inertia", "motor.viscous", "motor.coulomb")


@pytest.mark.parametrize("linear", [False, True])
def test_no_weight_swings_on_an_axis_that_slides(linear: bool) -> None:
    names = {one.name for one in candidates(Structure(AXIS, linear=linear), "speed")}
    assert ("motor.gravity" in names) != linear
    assert ("motor.geared_gravity" in names) != linear
    assert "motor.constant_torque" in names  # what weight is there
