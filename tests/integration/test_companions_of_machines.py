"""Companions on measured machines: pushes on a sliding axis, and the pose of an industrial robot."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.paths import CONFIGS, SHARED

from robotid.catalogue import assemble
from robotid.config.load import load
from robotid.config.schema import Config
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.rigid import fit_rigid
from robotid.model.companion import CompanionKind
from robotid.model.parameters import KnownParameter
from robotid.signals.companion import Companion
from robotid.signals.metrics import fit_percent
from robotid.signals.readers import read
from robotid.signals.record import Record
from robotid.stages.ingestion.measured import measured_records
from robotid.stages.ingestion.virtual import controller_of
from robotid.validation.closed_loop import loop_errors

CONTAINED = 1.01  # how much of the column of pulses the recorded force contains


def machine(name: str) -> tuple[Config, dict[str, Record]]:
    config = load(CONFIGS / f"{name}.yaml").config
    files = {one.name: CONFIGS / one.files[0] for one in config.records}
    if not all(path.is_file() for path in files.values()):
        pytest.skip(f"the measured records are not in {SHARED}")
    linear = config.robot.linear
    return config, {r.name: measured_records(r, read(files[r.name]), linear=linear)[0][0] for r in config.records}


def test_pushes_on_a_sliding_axis_explain_what_its_controller_did() -> None:
    """The controller's own force, with the pulses as a torque that acts beside it."""
    config, records = machine("emps")
    structure, effect = config.structure(), "motor.known_torque[push]"
    alone, pushed = assemble(structure), assemble(structure.extended(effect))
    pulses = records["pulses"].disturbance
    assert pulses is not None
    assert config.loop is not None
    push = Companion.of(CompanionKind.TORQUE, pulses, records["pulses"].sampling_time, "N")
    record = replace(records["pulses"], tau_m=records["pulses"].tau_m - CONTAINED * pulses, companions={"push": push})
    found = fit_rigid(pushed, pushed.parameters(), [record])
    assert found[f"{effect}.g"].value == pytest.approx(CONTAINED, rel=0.01)
    assert found.torque_error_percent["pulses"] < 3.0
    assert fit_rigid(alone, alone.parameters(), [record]).torque_error_percent["pulses"] > 50.0

    trained = fit_rigid(alone, alone.parameters(), [records["train"]]).guesses
    errors = []
    for known in (structure, structure.extended(effect)):
        joint = assemble(known, angle=True)
        values = trained | ({f"{effect}.g": found[f"{effect}.g"].value} if known is not structure else {})
        theta = joint.parameters().with_values(values).values
        errors.append(loop_errors(known, theta, controller_of(config.loop), record))
    without, beside = errors
    assert without is not None
    assert beside is not None
    assert without.torque_percent > 80.0
    assert beside.torque_percent < 5.0
    assert beside.position_rmse < 0.1 * without.position_rmse


def test_the_lever_of_another_axis_carries_over_to_poses_that_were_not_fitted() -> None:
    config, records = machine("kuka_axis1")
    joint = assemble(config.structure().extended("arm.pose_lever[q2]"))
    start = joint.parameters().with_known(config.robot.known())
    guesses = fit_rigid(joint, start, [records["A"]]).guesses
    start = start.with_known({name: KnownParameter(value) for name, value in guesses.items()})
    model = fitted_model(fit_model("A", joint, start, [records["A"]], FitOptions()))
    held_out = simulate_record(model, records["B"])
    assert fit_percent(held_out.measured("speed"), held_out.signal("speed")) > 81.0
