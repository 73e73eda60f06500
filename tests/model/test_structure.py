"""The make-up of a joint as names: effects added, taken away, and what goes with them."""

from __future__ import annotations

import pytest

from robotid.model.structure import Structure, change, changed

JOINT = Structure(
    ("motor.inertia", "motor.coulomb"), ("torque.torque_delay",), changes=(change("day2", "motor.coulomb.Fc"),)
)


@pytest.mark.parametrize("effect", ["motor.stribeck", "speed.sensor_delay", change("day 2", "motor.inertia.J")])
def test_what_was_added_can_be_taken_away(effect: str) -> None:
    more = JOINT.extended(effect)
    assert set(more.effects) == {*JOINT.effects, effect}
    assert more.without(effect) == JOINT


def test_an_effect_goes_with_the_changes_of_its_parameters() -> None:
    """A parameter that is no more cannot differ in a record."""
    assert JOINT.without("motor.coulomb").effects == ("motor.inertia", "torque.torque_delay")
    assert JOINT.without("motor.coul").changes == JOINT.changes


@pytest.mark.parametrize("record", ["day2", "day.2", "2024-11-21 10.30"])
def test_a_change_tells_its_record_and_its_parameter(record: str) -> None:
    assert changed(change(record, "arm.inertia.J")) == (record, "arm.inertia.J")
