"""A load behind an elastic gear is the joint of two masses, as seen from its motor."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate

RATIO, JM, JA, K, D = 0.02, 0.01, 20.0, 2e4, 60.0
MOTOR = {"motor.inertia.J": JM, "motor.viscous.Fv": 0.02, "motor.coulomb.Fc": 0.1}
RIGID = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
FLEXIBLE = Structure((*RIGID.terms, "gear.spring", "gear.damper", "arm.inertia"), gear_ratio=RATIO)


def speed(structure: Structure, values: dict[str, float]) -> np.ndarray:
    """Speed of the motor under two sines of torque that reverse it."""
    h, n = 1e-3, 3000
    t = np.arange(n) * h
    torque = 1.5 * np.sin(2 * np.pi * 0.9 * t) + 0.8 * np.sin(2 * np.pi * 4.0 * t)
    joint = assemble(structure, angle=True)
    record = Record("r", "estimate", "both", h, torque, np.zeros(n), np.zeros(n))
    return simulate(joint, joint.parameters().with_values(values).values, record, np.zeros(joint.nx)).dphi_m


def test_it_moves_as_the_joint_of_two_masses_does() -> None:
    w = np.sqrt(K / JA)
    load = {"J": RATIO**2 * JA, "w": w, "zeta": D / (2 * w * JA)}
    whole = speed(FLEXIBLE, {**MOTOR, "gear.spring.k1": K, "gear.damper.d": D, "arm.inertia.J": JA})
    seen = speed(
        RIGID.extended("motor.elastic_load"), {**MOTOR, **{f"motor.elastic_load.{k}": v for k, v in load.items()}}
    )
    assert np.abs(whole).max() > 5.0
    assert seen == pytest.approx(whole, abs=1e-4 * np.abs(whole).max())


@pytest.mark.parametrize("effect", ["motor.elastic_load", "motor.geared_gravity"])
def test_only_an_axis_without_a_gear_may_lack_it(effect: str) -> None:
    assert effect in {one.name for one in candidates(RIGID, "speed")}
    assert effect not in {one.name for one in candidates(FLEXIBLE, "speed")}
