"""`export`: what a run holds, in files of other programs, read back."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat
from support.paths import CONFIGS

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Fits
from robotid.export.handover.target import Target
from robotid.export.targets import TARGETS
from robotid.model.units import typeset
from robotid.signals.metrics import fit_percent
from robotid.signals.quality import Recordings
from robotid.signals.readers import read

SMOKE = CONFIGS / "smoke.yaml"


def export(artifact: Path, to: Path, *options: str) -> int:
    return main(["export", str(artifact), str(to), *options])


def test_a_model_as_matlab_json_and_csv(
    run_directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    artifact = run_directory / "model.h5"
    for suffix in (".mat", ".json", ".csv"):
        assert export(artifact, tmp_path / f"m{suffix}", "--speed", "5") == 0
        assert capsys.readouterr() == ("", f"{tmp_path / f'm{suffix}'} written: model m\n")
    fit = load(artifact, Fits).content.models["m"]
    matlab, plain = loadmat(tmp_path / "m.mat", simplify_cells=True), json.loads((tmp_path / "m.json").read_text())
    np.testing.assert_array_equal(matlab["A"], plain["A"])
    assert matlab["operating_point"]["dphi_m"] == plain["operating_point"]["dphi_m"] == 5.0
    assert plain["sampling_time"] == {"slow": 0.001, "wide": 0.001}
    assert plain["parameters"]["gear"]["spring"]["k1"]["value"] == fit["gear.spring.k1"].value
    table = read(tmp_path / "m.csv")
    np.testing.assert_array_equal(table.columns["value"], [p.value for p in fit.parameters])
    assert table.text["parameter"] == fit.parameters[0].name


def test_signals_come_back_as_a_record_with_the_simulation(run_directory: Path, tmp_path: Path) -> None:
    assert export(run_directory / "records.h5", tmp_path / "s.csv") == 0
    assert sorted(file.name for file in tmp_path.iterdir()) == ["s_slow.csv", "s_wide.csv"]
    record = load(run_directory / "records.h5", Recordings).content["wide"]
    table = read(tmp_path / "s_wide.csv")
    assert table.units["tau_m"] == "Nm"
    assert table.units["dphi_m_simulated"] == "rad/s"
    for name in ("t", "tau_m", "phi_m", "dphi_m", "ref"):
        np.testing.assert_array_equal(table.columns[name], getattr(record, name))
    fit = load(run_directory / "model.h5", Fits).content.models["m"]
    reached = fit_percent(table.columns["dphi_m"], table.columns["dphi_m_simulated"])
    assert reached == pytest.approx(fit.fit_percent["wide"], abs=0.01)


def test_one_record_goes_to_the_very_file(run_directory: Path, tmp_path: Path) -> None:
    assert export(run_directory / "records.h5", tmp_path / "s.csv", "--record", "slow") == 0
    assert [file.name for file in tmp_path.iterdir()] == ["s.csv"]


def test_all_records_in_one_matlab_file(run_directory: Path, tmp_path: Path) -> None:
    assert export(run_directory / "records.h5", tmp_path / "s.mat") == 0
    found = loadmat(tmp_path / "s.mat", simplify_cells=True)
    record = load(run_directory / "records.h5", Recordings).content["slow"]
    np.testing.assert_array_equal(found["slow"]["phi_m"], record.phi_m)
    assert found["slow"]["units"]["phi_m"] == "rad"


def test_responses(run_directory: Path, tmp_path: Path) -> None:
    assert export(run_directory / "flex.h5", tmp_path / "f.csv") == 0
    frf = load(run_directory / "flex.h5", FlexResult).content.frfs[0]
    table = read(tmp_path / "f.csv")
    np.testing.assert_array_equal(table.columns["frequency"], frf.frequency)
    np.testing.assert_array_equal(table.columns["real"] + 1j * table.columns["imag"], frf.response)
    np.testing.assert_allclose(
        table.columns["magnitude"] * np.exp(1j * table.columns["phase"]), frf.response, rtol=1e-12
    )
    np.testing.assert_array_equal(table.columns["std"], frf.std)
    assert table.units["frequency"] == "Hz"
    assert "real [rad/s2/Nm]" in (tmp_path / "f.csv").read_text().splitlines()[0]


def test_records_alone(run_directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(run_directory / "records.h5", tmp_path)
    assert export(tmp_path / "records.h5", tmp_path / "s.csv", "--record", "slow") == 0
    assert "there is no model.h5 beside it: measured signals alone are written" in capsys.readouterr().err
    assert "phi_m_simulated" not in (tmp_path / "s.csv").read_text().splitlines()[0]


def test_a_model_of_other_records(run_directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(run_directory / "model.h5", tmp_path)
    assert main(["excite", str(SMOKE), "--out", str(tmp_path), "--set", "plant.seed=7", "--quiet"]) == 0
    assert main(["collect", str(SMOKE), "--out", str(tmp_path), "--set", "plant.seed=7", "--quiet"]) == 0
    capsys.readouterr()
    assert export(tmp_path / "records.h5", tmp_path / "s.csv") == 2
    assert "its models were fitted to other records than records.h5 holds" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.csv"))


@pytest.mark.parametrize(
    ("artifact", "name", "options", "line"),
    [
        ("rigid.h5", "a.csv", [], "nothing is exported of what init-rigid makes; give model.h5, records.h5, flex.h5"),
        ("model.h5", "a.mta", [], 'nothing is exported as ".mta"; did you mean .mat?'),
        ("model.h5", "a.mat", ["--model", "m9"], 'there is no model "m9"; did you mean m?'),
        ("records.h5", "a.csv", ["--record", "slwo"], 'there is no record "slwo"; did you mean slow?'),
        ("flex.h5", "a.csv", ["--record", "x"], 'there is no record "x"; one of wide'),
    ],
)
def test_what_cannot_be_exported_is_said(
    artifact: str,
    name: str,
    options: list[str],
    line: str,
    run_directory: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert export(run_directory / artifact, tmp_path / name, *options) == 2
    assert line in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


ROBOT = '<robot name="r"><joint name="a" type="revolute"><limit/></joint><joint name="b" type="revolute"/></robot>'


@pytest.mark.parametrize("target", TARGETS.values(), ids=lambda target: target.name)
def test_a_model_for_another_program(
    target: Target, run_directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    to = tmp_path / f"joint{target.suffix}"
    assert export(run_directory / "model.h5", to) == 0
    talk = capsys.readouterr().err.splitlines()
    assert talk[0] == f"{to} written: model m, {target.summary}"
    text = to.read_text()
    for line in talk[1:]:
        assert line in typeset(text)
    assert ("kg m² at the joint" in " ".join(talk)) == (target.suffix == ".urdf") == ("kg m2 at the joint" in text)
    lacks = any(line.startswith("It lacks ") for line in talk)
    assert lacks == any(line.startswith("On wide the whole model fits ") for line in talk)
    assert lacks == (target.suffix == ".urdf")


def test_a_robot_description_gets_the_dynamics_of_a_joint(run_directory: Path, tmp_path: Path) -> None:
    given, to = tmp_path / "given.urdf", tmp_path / "new.urdf"
    given.write_text(ROBOT)
    assert export(run_directory / "model.h5", to, "--into", str(given), "--joint", "a") == 0
    assert given.read_text() == ROBOT
    assert to.read_text().startswith('<robot name="r"><joint name="a" type="revolute"><limit/>\n')
    assert to.read_text().count("<dynamics ") == 1


@pytest.mark.parametrize(
    ("artifact", "to", "options", "complaint"),
    [
        ("records.h5", "m.xml", (), ".xml is written of a model only"),
        ("model.h5", "m.xml", ("--into", "given.urdf"), "--into: no .urdf file is changed this way"),
        ("model.h5", "m.urdf", ("--into", "given.urdf", "--joint", "c"), '--into: it has no joint "c"'),
        ("model.h5", "m.xml", ("--record", "no"), 'there is no record "no"'),
    ],
)
def test_what_cannot_be_handed_over_is_refused(
    artifact: str,
    to: str,
    options: tuple[str, ...],
    complaint: str,
    run_directory: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("given.urdf").write_text(ROBOT)
    assert export(run_directory / artifact, Path(to), *options) == 2
    assert complaint in capsys.readouterr().err
    assert not Path(to).exists()


def test_a_description_that_is_not_there(
    run_directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "none.urdf"
    assert export(run_directory / "model.h5", tmp_path / "m.urdf", "--into", str(missing)) == 3
    assert f"{missing}: cannot be read" in capsys.readouterr().err
