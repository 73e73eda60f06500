"""The third mass against the textbook's vibration absorber."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.term import Motion
from robotid.terms import TERMS

JB, WB, ZETA = 120.0, 75.0, 0.04


def apparent_inertia(omega: float) -> complex:
    """Torque over acceleration of the arm at one frequency [rad/s], from the term's own partials."""
    rest = np.zeros(1)
    m = Motion(rest, rest, rest, rest, rest, np.zeros((2, 1)))
    term, p = TERMS["third_mass"], (JB, WB, ZETA)
    d, rates = term.partials(m, p), term.rate_partials(m, p)
    A = np.array([r.z for r in rates], dtype=float)
    b = np.array([r.v for r in rates], dtype=float)
    z = np.linalg.solve(1j * omega * np.eye(2) - A, b)
    return complex((d.v + np.array(d.z) @ z) / (1j * omega))


def test_slow_motion_carries_the_tool_along() -> None:
    assert apparent_inertia(1e-3 * WB) == pytest.approx(JB, rel=1e-5)


@pytest.mark.parametrize("omega", [10.0, 70.0, 75.0, 300.0])
def test_is_an_inertia_behind_spring_and_damper(omega: float) -> None:
    s, k, d = 1j * omega, JB * WB**2, 2.0 * ZETA * WB * JB
    link = k + d * s
    assert apparent_inertia(omega) == pytest.approx(JB * link / (JB * s**2 + link), rel=1e-12)


def test_resonance_has_the_height_of_its_damping_ratio() -> None:
    assert abs(apparent_inertia(WB)) == pytest.approx(JB * np.sqrt(1 + 4 * ZETA**2) / (2 * ZETA), rel=1e-12)
