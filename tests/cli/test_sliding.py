"""Views of an axis that slides."""

from __future__ import annotations

from dataclasses import replace

import pytest
from diagnosed import EXTENSION

from robotid.cli.console import Table
from robotid.cli.views.sliding import of_axis, slid

TABLE = Table(
    "Errors [rad]", ("what", "RMSE [rad/s]", "gain [% points]", "unit"), (("floor [rad]", "1", "2", "Nm s/rad"),)
)


@pytest.mark.parametrize("linear", [True, False])
def test_units_are_those_of_the_axis(linear: bool) -> None:
    found = slid(TABLE, linear=linear)
    said = ("what", "RMSE [m/s]", "gain [% points]", "unit"), (("floor [m]", "1", "2", "N s/m"),)
    assert ((found.columns, found.rows) == said) is linear
    assert (found == TABLE) is not linear


def test_a_slid_table_stays_as_it_is() -> None:
    once = slid(TABLE, linear=True)
    assert slid(once, linear=True) == once


def test_sentences_take_the_unit_from_the_content() -> None:
    position = replace(EXTENSION, unit="rad")
    assert of_axis(position, linear=True).unit == "m"
    assert of_axis(position, linear=False) is position
    assert of_axis("anything else", linear=True) == "anything else"
