"""Stage fit: a doubtful model is tried again with a constant torque free, beside it."""

from __future__ import annotations

import numpy as np
import pytest
from support.dry_axis import DryAxis, switched_torque

from robotid.config.schema import Config
from robotid.estimate.flexible import FlexResult
from robotid.estimate.rigid import fit_rigid
from robotid.estimate.sensing import joint_for
from robotid.signals.quality import Recordings
from robotid.signals.record import Record
from robotid.stages.fit import fit

H, N = 2e-3, 2000


def recordings(offset: float) -> Recordings:
    """An axis on a torque that is recorded with an offset."""
    t, axis = np.arange(N) * H, DryAxis()
    torque = switched_torque(t)
    speed, angle = axis.motion(t, torque, t)
    measured = speed + 0.01 * np.random.default_rng(0).standard_normal(N)
    return Recordings((Record.from_arrays(torque + offset, angle, H, speed=measured, name="log"),), ())


def config() -> Config:
    robot = {"name": "axis", "model": {"motor": ("inertia", "viscous", "coulomb")}}
    return Config.model_validate({"robot": robot, "records": ({"name": "log", "file": "log.csv"},)}).completed()


@pytest.mark.parametrize(("offset", "models"), [(0.0, ["m1"]), (0.4, ["m1", "m1_offset"])])
def test_a_constant_torque_is_tried_where_the_fit_is_doubtful(offset: float, models: list[str]) -> None:
    data, settings = recordings(offset), config()
    joint = joint_for(settings.structure(), "speed", data.records)
    rigid = fit_rigid(joint, joint.parameters(), list(data.records))
    found = fit(settings, data, rigid, FlexResult((), (), (), (), {}, ()))
    assert list(found.models) == models
    assert found.best == "m1"
    last = found.models[models[-1]]
    assert last["motor.inertia.J"].value == pytest.approx(0.01, rel=0.01)
    assert last["motor.coulomb.Fc"].value == pytest.approx(0.5, rel=0.01)
    assert ("constant torque" in " ".join(found.models["m1"].remarks)) == (offset > 0.0)
