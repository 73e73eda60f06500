"""Friction laws at values that can be checked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.term import Motion
from robotid.terms import TERMS


def at_speed(*v: float) -> Motion:
    speed = np.array(v)
    rest = np.zeros_like(speed)
    return Motion(rest, speed, rest, np.sign(speed), rest, np.zeros((0, len(speed))))


@pytest.mark.parametrize(
    ("name", "p", "expected"),
    [
        ("coulomb", (0.6,), [-0.6, -0.6, 0.6, 0.6]),
        ("viscous", (0.1,), [-0.2, -0.1, 0.1, 0.2]),
        ("asymmetric_coulomb", (0.3,), [0.3, 0.3, 0.3, 0.3]),
        ("asymmetric_viscous", (0.1,), [0.2, 0.1, 0.1, 0.2]),
        ("stribeck", (1.0, 1.0), [-np.exp(-4), -np.exp(-1), np.exp(-1), np.exp(-4)]),
    ],
)
def test_torque_over_speed(name: str, p: tuple[float, ...], expected: list[float]) -> None:
    np.testing.assert_allclose(TERMS[name].torque(at_speed(-2.0, -1.0, 1.0, 2.0), p), expected, rtol=1e-15)


def test_direction_dependent_friction_is_two_laws_in_one() -> None:
    forwards, backwards = {"Fc": 20.14, "Fv": 166.7}, {"Fc": 20.63, "Fv": 240.4}
    mean = {k: (forwards[k] + backwards[k]) / 2 for k in forwards}
    half = {k: (forwards[k] - backwards[k]) / 2 for k in forwards}
    laws = {
        "coulomb": mean["Fc"],
        "viscous": mean["Fv"],
        "asymmetric_coulomb": half["Fc"],
        "asymmetric_viscous": half["Fv"],
    }
    tau = sum(TERMS[name].torque(at_speed(-2.0, 3.0), (level,)) for name, level in laws.items())
    np.testing.assert_allclose(tau, [-20.63 - 240.4 * 2.0, 20.14 + 166.7 * 3.0], rtol=1e-14)
