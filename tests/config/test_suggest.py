"""Did you mean."""

import pytest

from robotid.config.suggest import nearest, suggest

WORDS = ("spring", "cubic_spring", "coulomb", "asymmetric_coulomb", "viscous")


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("spring_cubik", "cubic_spring"),
        ("Cubic-Spring", "cubic_spring"),
        ("columb", "coulomb"),
        ("viscuos", "viscous"),
        ("assymetric_coulomb", "asymmetric_coulomb"),
        ("gravity", None),
    ],
)
def test_nearest(word: str, meant: str | None) -> None:
    assert nearest(word, WORDS) == meant


def test_a_short_list_is_told_in_full_where_nothing_is_near() -> None:
    assert suggest("xyz", ("speed", "position")) == "one of speed, position"
    assert suggest("xyz", ("speed", "position"), many=1) == ""
    assert suggest("xyz", ()) == ""
