"""Effects that read a further column, from Python: read, fitted, saved, loaded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.logs import TRUTH, motor_log

import robotid as rid

PUSH = {"push": {"name": "force", "kind": "torque"}}
MODEL = ("inertia", "viscous", "coulomb", "known_torque[push]")


def pushed(seed: int = 1) -> dict[str, np.ndarray]:
    """The log of a motor that a recorded torque helps by what its own torque lacks."""
    log = motor_log(seed=seed)
    force = 0.5 * np.sin(2 * np.pi * 1.7 * log["time"])
    return log | {"torque": log["torque"] - force, "force": force}


def test_a_model_with_a_companion_is_fitted_saved_and_loaded(tmp_path: Path) -> None:
    data = rid.read(pushed(), name="log", signals=PUSH)
    fit = rid.fit(rid.Model(motor=MODEL), data)
    assert abs(fit["motor.known_torque[push].g"].value) == pytest.approx(1.0, rel=0.02)
    assert fit["motor.inertia.J"].value == pytest.approx(TRUTH["motor.inertia.J"], rel=0.02)
    again = rid.load(rid.save(fit, tmp_path / "run"))
    assert again.fit.values == fit.values
    assert again.model.motor == MODEL
    other = rid.read(pushed(2), name="other", signals=PUSH)
    assert rid.validate(again.fit, other).models[fit.name].records["other"].fit_percent > 95.0


def test_records_without_the_companion_are_refused_in_a_line() -> None:
    with pytest.raises(rid.RobotidError) as caught:
        rid.fit(rid.Model(motor=MODEL), rid.read(motor_log(), name="log"))
    assert "push" in str(caught.value)


def test_an_effect_of_a_companion_must_name_one() -> None:
    with pytest.raises(rid.RobotidError) as caught:
        rid.Model(motor=["inertia", "known_torque"])
    assert "reads a companion of kind torque" in str(caught.value)
