"""The errors of several axes in one line."""

from __future__ import annotations

from robotid.errors import NumericsError
from robotid.pipeline.execute import one_error


def test_an_axis_that_fails_alone_is_named_before_its_place() -> None:
    placed, bare = NumericsError("it diverges", where="set1"), NumericsError("it diverges")
    assert str(one_error({"a2": placed})) == "axis a2: set1: it diverges"
    assert str(one_error({"a2": bare})) == "axis a2: it diverges"


def test_several_axes_share_a_line() -> None:
    both = one_error({"a1": NumericsError("it diverges"), "a2": NumericsError("it stalls", where="set1")})
    assert str(both) == "axis a1: it diverges; axis a2: set1: it stalls"
