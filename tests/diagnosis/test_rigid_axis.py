"""What a model of a rigid axis lacks where the machine has a gear: it flexes, and the arm behind it weighs."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_bench import AXIS, SAMPLING_TIME, TRUTH, Criteria, fitted, records_of

from robotid.catalogue import assemble
from robotid.diagnosis.procedure import diagnose
from robotid.model.structure import Structure

RATIO, ARM = 0.01, 40.0
FLEXIBLE = Structure((*AXIS.terms, "gear.spring", "gear.damper", "arm.inertia"), gear_ratio=RATIO)


@pytest.mark.parametrize("stiffness", [2e4, 2e5])
def test_an_axis_that_flexes_is_named_with_its_notch(stiffness: float) -> None:
    own = {"gear.spring.k1": stiffness, "gear.damper.d": 20.0, "arm.inertia.J": ARM}
    truth = TRUTH | own | {"motor.inertia.J": TRUTH["motor.inertia.J"] - RATIO**2 * ARM}
    made = records_of(assemble(FLEXIBLE, angle=True), truth)
    found = diagnose(fitted(made), made, Criteria(max_refits=2))
    assert found.verdict == "named"
    assert [cause.effect for cause in found.causes] == ["motor.elastic_load"]
    values = {one.name.rpartition(".")[2]: one.value for one in found.causes[0].parameters}
    assert values["J"] == pytest.approx(RATIO**2 * ARM, rel=0.01)
    assert values["w"] == pytest.approx(np.sqrt(stiffness / ARM), rel=0.01)
    assert found.remaining < 0.1 * found.misfit


def test_the_weight_behind_a_gear_is_named_with_its_ratio_and_then_the_gear() -> None:
    terms = (*FLEXIBLE.terms, "arm.gravity")
    own = {"gear.spring.k1": 2e6, "gear.damper.d": 300.0, "arm.inertia.J": ARM, "arm.gravity.G": 20.0}
    truth = TRUTH | own | {"arm.gravity.H": 20.0, "motor.inertia.J": TRUTH["motor.inertia.J"] - RATIO**2 * ARM}
    t = np.arange(4000) * SAMPLING_TIME
    swings = {
        "slow": 60 * np.sin(2 * np.pi * 0.25 * t) + 10 * np.sin(2 * np.pi * 1.7 * t),
        "wide": 80 * np.sin(2 * np.pi * 0.37 * t + 1.0) - 80 * np.sin(1.0) + 20 * np.sin(2 * np.pi * 2.3 * t),
        "check": 50 * np.sin(2 * np.pi * 0.31 * t) + 15 * np.sin(2 * np.pi * 1.1 * t),
    }
    made = records_of(assemble(Structure(terms, gear_ratio=RATIO), angle=True), truth, wanted=swings)
    found = diagnose(fitted(made), made, Criteria(max_refits=2))
    assert [cause.effect for cause in found.causes] == ["motor.geared_gravity", "motor.elastic_load"]
    assert all(cause.p_value < 1e-6 for cause in found.causes)
    assert found.remaining < 0.1 * found.misfit
    values, flexible = ({p.name.rpartition(".")[2]: p.value for p in cause.parameters} for cause in found.causes)
    assert flexible["w"] == pytest.approx(np.sqrt(2e6 / ARM), rel=0.02)
    assert values["r"] == pytest.approx(RATIO, rel=0.05)
    assert values["G"] == pytest.approx(20.0 * RATIO, rel=0.05)
    assert values["H"] == pytest.approx(20.0 * RATIO, rel=0.05)
