"""The motion that a term acts on: the same at another acceleration."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from robotid.model.derivatives import Tangent
from robotid.model.port_motion import PortMotion
from robotid.model.term import Motion


def test_an_acceleration_changes_nothing_else() -> None:
    motion = Motion(**{f.name: np.full((1, 2), float(k)) for k, f in enumerate(fields(Motion))})
    port = PortMotion(motion, *(Tangent({k: 1.0}) for k in range(4)), ())
    moved, a = port.accelerated(np.array([7.0, 8.0])), np.array([7.0, 8.0])
    np.testing.assert_array_equal(moved.m.a, a)
    for f in fields(Motion):
        assert f.name == "a" or getattr(moved.m, f.name) is getattr(motion, f.name)
    assert all(getattr(moved, f.name) is getattr(port, f.name) for f in fields(PortMotion) if f.name != "m")
