"""Views of an axis that slides."""

from __future__ import annotations

import re

import pytest

from robotid.channels import CHANNELS
from robotid.model.units import sliding
from robotid.report.tables.sliding import in_units_of_axis, in_words_of_axis
from robotid.report.tables.table import Table
from robotid.terms import TERMS

TABLE = Table(
    "Errors [rad]", ("what", "RMSE [rad/s]", "gain [% points]", "unit"), (("floor [rad]", "1", "2", "Nm s/rad"),)
)


@pytest.mark.parametrize("linear", [True, False])
def test_units_are_those_of_the_axis(linear: bool) -> None:
    found = in_units_of_axis(TABLE, linear=linear)
    said = ("what", "RMSE [m/s]", "gain [% points]", "unit"), (("floor [m]", "1", "2", "N s/m"),)
    assert ((found.columns, found.rows) == said) is linear
    assert (found == TABLE) is not linear


def test_a_slid_table_stays_as_it_is() -> None:
    once = in_units_of_axis(TABLE, linear=True)
    assert in_units_of_axis(once, linear=True) == once


def test_words_are_those_of_the_axis_and_names_stay() -> None:
    table = Table(
        "Torque error",
        ("record", "largest missing torque [Nm]", "motor angle", "why"),
        (("torque", "2", "3", "motor.constant_torque carries 5 % of the torque at the motor; torque.torque_lag"),),
        "share of the missing torque's variance",
    )
    found = in_units_of_axis(table, linear=True)
    assert (found.title, found.note) == ("Force error", "share of the missing force's variance")
    assert found.columns == ("record", "largest missing force [N]", "motor position", "why")
    why = "motor.constant_torque carries 5 % of the force at the motor; torque.torque_lag"
    assert found.rows == (("torque", "2", "3", why),)


@pytest.mark.parametrize(
    "unit", sorted({p.unit for effect in (*TERMS.values(), *CHANNELS.values()) for p in effect.parameters})
)
def test_every_unit_slides_once(unit: str) -> None:
    assert not re.search("rad|Nm|kg m2", sliding(unit))
    assert sliding(sliding(unit)) == sliding(unit)


def test_a_sentence_has_the_words_of_the_axis() -> None:
    said = "m1: with a constant torque of 3.46 N the fit rises"
    assert in_words_of_axis(said, linear=False) == said
    assert in_words_of_axis(said, linear=True) == "m1: with a constant force of 3.46 N the fit rises"
