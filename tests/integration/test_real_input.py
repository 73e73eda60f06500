"""The shipped configurations as a user runs them: the paper's experiment, and machines with published results."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from support.paper_joint import TRUTH
from support.paths import ROOT

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.estimate.flexible import FlexResult
from robotid.estimate.rigid import RigidResult

CONFIGS = ROOT / "configs"
MEASURED = ROOT.parent / "shared" / "data"


def need(folder: str) -> None:
    if not (MEASURED / folder).is_dir():
        pytest.skip(f"the measured records {folder} are third-party data and not here")


def run(config: str, out: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    """JSON of the stages up to the validation, which a fit needs; the diagnosis has tests of its own."""
    documents = {}
    for stage in ("excite", "collect", "init-rigid", "init-flex", "fit", "validate"):
        assert main([stage, str(CONFIGS / config), "--out", str(out), "--json"]) == 0
        documents[stage] = json.loads(capsys.readouterr().out)
    return documents


def values(document: dict[str, Any]) -> dict[str, float]:
    return {name: parameter["value"] for name, parameter in document["parameters"].items()}


def test_the_papers_experiment(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done = run("paper.yaml", tmp_path, capsys)
    start = (
        load(tmp_path / "rigid.h5", RigidResult).content.guesses
        | load(tmp_path / "flex.h5", FlexResult).content.guesses
    )
    for name in set(TRUTH) - {"gear.cubic_spring.k3"}:
        assert start[name] == pytest.approx(TRUTH[name], rel=0.03), name
    assert start["gear.cubic_spring.k3"] == 0.0
    m3 = done["fit"]["models"]["m3"]
    assert m3["converged"]
    assert sorted(m3["fit_percent"].values()) == pytest.approx([99.75, 99.84, 99.91], abs=0.02)
    for name, parameter in m3["parameters"].items():
        assert abs(parameter["value"] - TRUTH[name]) <= 3 * parameter["std_robust"], name
    k3 = done["validate"]["models"]["m3"]["identifiability"]["gear.cubic_spring.k3"]
    assert k3["verdict"] == "unseen"
    assert "% of the torque at the gear" in k3["why"]


def test_emps_symmetric(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    need("emps")
    done = run("emps.yaml", tmp_path, capsys)
    rigid = values(done["init-rigid"])
    assert rigid["motor.inertia.J"] == pytest.approx(95.11, rel=0.01)
    assert rigid["motor.viscous.Fv"] == pytest.approx(203.5, rel=0.01)
    assert rigid["motor.coulomb.Fc"] == pytest.approx(20.39, rel=0.01)
    assert rigid["motor.constant_torque.tau0"] == pytest.approx(-3.165, rel=0.03)
    assert done["init-rigid"]["torque_error_percent"]["train"] <= 4.1
    records = done["validate"]["models"]["symmetric"]["records"]
    assert records["pulses"]["rmse"]["position"] <= 0.0048
    assert records["train"]["closed_loop"]["position_percent"] <= 0.0138


def test_emps_with_friction_by_direction(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    need("emps")
    done = run("emps_asymmetric.yaml", tmp_path, capsys)
    found = values(done["init-rigid"])
    viscous, coulomb = found["motor.viscous.Fv"], found["motor.coulomb.Fc"]
    by_direction = found["motor.asymmetric_viscous.dFv"], found["motor.asymmetric_coulomb.dFc"]
    assert found["motor.inertia.J"] == pytest.approx(95.15, rel=0.01)
    assert viscous + by_direction[0] == pytest.approx(166.7, rel=0.01)
    assert viscous - by_direction[0] == pytest.approx(240.4, rel=0.01)
    assert coulomb + by_direction[1] == pytest.approx(20.14, rel=0.01)
    assert coulomb - by_direction[1] == pytest.approx(20.63, rel=0.01)
    assert done["init-rigid"]["torque_error_percent"]["train"] <= 3.2


def test_kuka_axis_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    need("kuka_kr300")
    done = run("kuka_axis1.yaml", tmp_path, capsys)
    records = done["validate"]["models"]["A"]["records"]
    assert records["A"]["fit_percent"] > 80
    assert records["B"]["fit_percent"] > 60
    arm = done["fit"]["models"]["A"]["parameters"]["arm.inertia.J"]
    assert 1000 < arm["value"] < 2000


@pytest.mark.parametrize("config", ["demo.yaml", "smoke.yaml"])
def test_shipped_examples_pass_their_own_threshold(
    config: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = run(config, tmp_path, capsys)
    for model in done["fit"]["models"].values():
        assert model["converged"]
        for name, parameter in model["parameters"].items():
            assert abs(parameter["value"] - TRUTH[name]) <= 4 * parameter["std_robust"], name


def test_a_threshold_missed_is_exit_5_and_the_artifact_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    demand = "validate.thresholds.fit_percent.wide=99.99"
    code = main(["run", str(CONFIGS / "smoke.yaml"), "--out", str(tmp_path), "--set", demand])
    assert code == 5
    assert (tmp_path / "validation.h5").is_file()
    assert "wide" in capsys.readouterr().err
