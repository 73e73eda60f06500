"""A description is the declaration, no more and no less."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest

from robotid.channels import CHANNELS
from robotid.model.describe import describe
from robotid.terms import TERMS


def test_term() -> None:
    found = describe(TERMS["cubic_spring"])
    assert (found.name, found.kind) == ("cubic_spring", "term")
    assert found.ports[0] == "gear"
    assert found.formula == "k3 x^3"
    assert [(p.symbol, p.unit, p.null) for p in found.parameters] == [("k3", "Nm/rad3", 0.0)]
    assert found.source.startswith("Wernholt & Gunnarsson 2005")
    assert found.signature == TERMS["cubic_spring"].signature


def test_channel() -> None:
    found = describe(CHANNELS["torque_delay"])
    assert (found.kind, found.ports) == ("channel", ("torque",))
    assert [p.symbol for p in found.parameters] == ["Td"]


def test_description_cannot_be_changed() -> None:
    with pytest.raises(FrozenInstanceError):
        describe(TERMS["inertia"]).name = "mass"  # type: ignore[misc]
