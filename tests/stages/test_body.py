"""The body of a two-link arm, from a configuration and a file to the simulation of one axis."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import planar_arm

from robotid.config.load import load, load_robot
from robotid.errors import ConfigError
from robotid.estimate.body import identify_body
from robotid.model.companion import CompanionKind
from robotid.signals.quality import Recordings
from robotid.signals.readers import read
from robotid.stages.collect import Common, collect
from robotid.stages.fit import fit
from robotid.stages.ingestion.body import body_setup
from robotid.stages.init_flex import init_flex
from robotid.stages.init_rigid import init_rigid

H = 0.002
RATIOS = (0.01, 0.02)
DESCRIPTION = """\
    gravity: [0.0, -9.81, 0.0]
    dh: [{a: 0.5}, {a: 0.3}]
    friction: [viscous, coulomb]
"""
CONFIG = """\
robot:
  name: arm
  gear_ratio: 0.01
  model: {{motor: [inertia, viscous, coulomb], arm: ["known_inertia[body_inertia]", "known_torque[body_torque]"]}}
  body:
{description}\
    axis: a1
    axes: {{a1: {{}}, a2: {{angle: q2, torque: t2, gear_ratio: 0.02}}}}
records:
  - &first
    name: one
    file: one.csv
    columns: {{tau_m: tau1, phi_m: phi1, dphi_m: null}}
    signals:
      q2: {{name: q2, unit: rad, kind: angle}}
      t2: {{name: tau2, unit: Nm, kind: drive}}
  - {{<<: *first, name: two, file: two.csv, role: validate}}
"""


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A configuration and its two files, of the motors' torques and the angles."""
    t = np.arange(8000) * H
    for seed, name in ((1, "one"), (2, "two")):
        q, dq, ddq = planar_arm.swing(seed, t)
        tau = planar_arm.torque(q, dq, ddq) * np.array(RATIOS)[:, None]
        table = np.column_stack([t, tau[0], q[0] / RATIOS[0], q[1], tau[1]])
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header="t,tau1,phi1,q2,tau2", comments="")
    path = tmp_path / "arm.yaml"
    path.write_text(CONFIG.format(description=DESCRIPTION))
    return path


def collected(path: Path) -> Recordings:
    config = load(path).config
    return collect(config, None, {r.name: read(path.parent / r.files[0]) for r in config.records})


def test_the_body_adds_inertia_and_torque_of_the_axis_to_every_record(arm: Path) -> None:
    found = collected(arm)
    assert found.body is not None
    assert found.body.axes == ("a1", "a2")
    inside, means = slice(300, -300), []
    for record in found.records:
        q, dq, ddq = planar_arm.swing(1 if record.name == "one" else 2, record.t)
        own = planar_arm.mass_matrix(q)[0, 0]
        rest = planar_arm.body_torque(q, dq, ddq)[0] - own * ddq[0]
        inertia, torque = record.companions["body_inertia"], record.companions["body_torque"]
        assert (inertia.kind, torque.kind) == (CompanionKind.INERTIA, CompanionKind.TORQUE)
        assert np.abs(torque.values + rest)[inside].max() < 0.05 * np.abs(rest).max()
        means.append((own - inertia.values)[inside])
    assert np.ptp(np.concatenate(means)) < 0.05 * np.mean(means)  # the same mean inertia everywhere


def test_the_body_is_identified_once_for_all_axes(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config, times = load(arm).config, []
    files = {r.name: read(arm.parent / r.files[0]) for r in config.records}
    monkeypatch.setattr("robotid.stages.collect.identify_body", lambda *given: times.append(1) or identify_body(*given))
    common = Common()
    one, other = (collect(config, None, files, shared=common) for _ in range(2))
    assert len(times) == 1
    assert one.body is other.body
    apart = config.model_copy(update={"records": config.records[:1]})
    assert collect(apart, None, files, shared=common).body is not one.body  # of other records


def test_an_axis_is_simulated_with_the_body(arm: Path) -> None:
    config, records = load(arm).config, collected(arm)
    rigid = init_rigid(config, records)
    assert rigid["arm.known_torque[body_torque].g"].value == pytest.approx(1.0, abs=0.05)
    assert rigid["arm.known_inertia[body_inertia].s"].value == pytest.approx(1.0, abs=0.2)
    model = fit(config, records, rigid, init_flex(config, records, rigid)).models["m1"]
    assert model.fit_percent["one"] > 98.0


def test_every_axis_finds_the_same_body(arm: Path) -> None:
    first = collected(arm).body
    text = arm.read_text().replace("gear_ratio: 0.01\n", "gear_ratio: 0.02\n")
    text = text.replace("tau1, phi_m: phi1", "tau2, phi_m: {name: q2, scale: 50.0}")
    text = text.replace("q2: {name: q2,", "q1: {name: phi1, scale: 0.01,").replace("t2: {name: tau2", "t1: {name: tau1")
    text = text.replace("axis: a1", "axis: a2")
    text = text.replace("{a1: {}, a2: {angle: q2, torque: t2, gear_ratio: 0.02}}", AXES_OF_SECOND)
    arm.write_text(text)
    second = collected(arm).body
    assert first is not None
    assert second is not None
    for one, other in zip(first.parameters, second.parameters, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-6, abs=1e-9)


AXES_OF_SECOND = "{a1: {angle: q1, torque: t1, gear_ratio: 0.01}, a2: {}}"


def test_a_urdf_beside_the_configuration_describes_the_same_arm(arm: Path) -> None:
    by_rows = collected(arm).body
    (arm.parent / "arm.urdf").write_text(URDF)
    arm.write_text(CONFIG.format(description=DESCRIPTION.replace("dh: [{a: 0.5}, {a: 0.3}]", URDF_KEYS)))
    config = load(arm).config
    assert config.robot.body is not None
    assert config.robot.body.urdf == URDF  # so that what is made of it is stale when it changes
    by_urdf = collected(arm).body
    assert by_rows is not None
    assert by_urdf is not None
    assert by_urdf["a2.Fc"].value == pytest.approx(by_rows["a2.Fc"].value, rel=1e-3)


URDF_KEYS = "urdf: arm.urdf\n    joints: {a1: shoulder, a2: elbow}"
URDF = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.5 0 0"/>
<axis xyz="0 0 1"/></joint></robot>
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("    dh: [{a: 0.5}, {a: 0.3}]\n", "", "either urdf or dh"),
        ("dh: [{a: 0.5}, {a: 0.3}]", "dh: [{a: 0.5}]", "1 rows of dh for 2 axes"),
        ("dh: [{a: 0.5}, {a: 0.3}]", "urdf: nowhere.urdf", "cannot be read"),
        ("axis: a1", "axis: a3", "axis a3 is none of a1, a2"),
        ("torque: t2, ", "", "axis a2 needs angle and torque"),
        ("torque: t2", "torque: t3", "one has no signal t3"),
        ("kind: drive", "kind: torque", "t2 is of kind torque, not drive"),
        ("      q2: {", "      body_torque: {name: tau2, kind: torque}\n      q2: {", "is what robot.body adds"),
        ("    axis: a1", "    rotors: {a9: 1.0}\n    axis: a1", "rotors names a9"),
    ],
)
def test_a_body_that_does_not_fit_is_refused(arm: Path, old: str, new: str, message: str) -> None:
    arm.write_text(arm.read_text().replace(old, new))
    with pytest.raises(ConfigError, match=message):
        load_robot(arm)


def test_a_record_without_a_signal_is_refused(arm: Path) -> None:
    config, records = load(arm).config, collected(arm)
    bare = Recordings(tuple(r.piece(0, len(r)) for r in records.records), records.reports)
    bare.records[0].companions.pop("t2")
    with pytest.raises(ConfigError, match="one has no signal t2"):
        identify_body(bare, body_setup(config.robot))
