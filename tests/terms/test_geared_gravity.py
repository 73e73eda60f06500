"""Weight behind a gear is that of the arm, by the ratio at the motor."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate

RATIO = 0.02
MOTOR = {"motor.inertia.J": 0.02, "motor.viscous.Fv": 0.02}


def speed(structure: Structure, values: dict[str, float]) -> np.ndarray:
    """Speed of the motor as the arm swings by a radian."""
    h, n = 2e-3, 3000
    t = np.arange(n) * h
    joint = assemble(structure, angle=True)
    record = Record("r", "estimate", "both", h, 0.6 * np.sin(2 * np.pi * 0.5 * t), np.zeros(n), np.zeros(n))
    return simulate(joint, joint.parameters().with_values(values).values, record, np.zeros(joint.nx)).dphi_m


def test_it_is_the_weight_of_an_arm_on_a_stiff_gear() -> None:
    """A spring that hardly twists, a light arm: gravity at the arm is seen at the motor by the ratio."""
    motor = ("motor.inertia", "motor.viscous")
    arm = Structure((*motor, "gear.spring", "gear.damper", "arm.inertia", "arm.gravity"), gear_ratio=RATIO)
    parts = {"gear.spring.k1": 1e6, "gear.damper.d": 1e3, "arm.inertia.J": 1.0}
    whole = speed(arm, MOTOR | parts | {"arm.gravity.G": 12.0, "arm.gravity.H": 5.0})
    inertia = {"motor.inertia.J": MOTOR["motor.inertia.J"] + RATIO**2 * 1.0}
    own = {f"motor.geared_gravity.{k}": v for k, v in (("G", 12.0 * RATIO), ("H", 5.0 * RATIO), ("r", RATIO))}
    seen = speed(Structure((*motor, "motor.geared_gravity")), MOTOR | inertia | own)
    assert np.abs(np.diff(whole)).max() > 0.0
    assert seen == pytest.approx(whole, abs=2e-3 * np.abs(whole).max())
