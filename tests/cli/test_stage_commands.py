"""Stage commands: what is run, what is told where, what is fresh."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import pytest
from support.diagnosed import UNKNOWN
from support.small_axis import CONFIG

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import save
from robotid.cli.app import main
from robotid.config.load import load
from robotid.pipeline.table import STAGES


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "axis.yaml").write_text(CONFIG)
    return "axis.yaml"


def test_a_stage_writes_its_artifact_and_a_table(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["excite", config]) == 0
    out, err = capsys.readouterr()
    assert Path("runs/axis/excitation.h5").is_file()
    assert "slow" in out
    assert err.startswith("excite: runs/axis/excitation.h5 written in ")
    assert err.endswith(" s (not made yet)\nnext: robotid collect axis.yaml\n")


def test_what_is_fresh_is_not_made_again_unless_forced(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["excite", config])
    first = capsys.readouterr().out
    assert main(["excite", config]) == 0
    assert capsys.readouterr() == (
        first,
        "excite: runs/axis/excitation.h5 is fresh\nnext: robotid collect axis.yaml\n",
    )
    assert main(["excite", config, "--force"]) == 0
    assert " s (forced)\n" in capsys.readouterr().err


def test_a_change_by_option_makes_it_stale(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["excite", config])
    capsys.readouterr()
    change = ["--set", "records.slow.excite.amplitude=10"]
    assert main(["excite", config, *change]) == 0
    line, following = capsys.readouterr().err.splitlines()
    assert line.endswith(" s (configuration changed: records)")
    assert following == f"next: robotid collect axis.yaml {' '.join(change)}"


def test_json_is_one_document_and_quiet_is_quiet(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["excite", config, "--json", "--quiet"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["references"]["slow"]["samples"] == 400
    assert err == ""


def test_quiet_prints_errors_alone(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", config, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_run_closes_with_what_it_reached_and_what_to_type_next(
    finished: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", finished]) == 0
    *_, reached, _, _, page, following = capsys.readouterr().err.splitlines()
    assert reached.startswith("m1 simulates slow to 9")
    assert page == "the report is runs/axis/report.html"
    assert following == "next: robotid show runs/axis/validation.h5"
    assert main(["status", finished]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == following
    assert main(["status", finished, "--set", "fit.max_iterations=7"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "next: robotid run axis.yaml --set fit.max_iterations=7"


def test_a_dry_run_makes_nothing(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", config, "--dry-run", "--json"]) == 0
    out, err = capsys.readouterr()
    plan = json.loads(out)["stages"]
    assert [entry["why"] for entry in plan] == ["not made yet"] + ["an earlier stage would run"] * len(STAGES)
    assert err == ""
    assert not Path("runs").exists()


def test_a_missing_input_names_the_command_that_makes_it(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", config, "--out", "elsewhere"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("elsewhere/records.h5: is missing; run `robotid collect axis.yaml")


def test_status_tells_what_is_fresh(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["excite", config, "--quiet"])
    capsys.readouterr()
    assert main(["status", config, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["stages"]
    assert (found["excite"]["state"], found["excite"]["why"]) == ("fresh", "")
    assert (found["collect"]["state"], found["collect"]["why"]) == ("absent", "not made yet")
    assert main(["status", config, "--set", "plant.seed=7"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines[2:4]] == [["excite", "stale"], ["collect", "absent"]]
    assert "configuration changed: plant" in lines[2]


def test_status_names_the_stage_that_is_damaged(finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    with h5py.File("runs/axis/extension.h5", "r+") as artifact:
        artifact["content/bic_after"][()] += 1
    assert main(["status", finished]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "damaged: the file does not match its checksum" in next(line for line in lines if "extend" in line)
    assert lines[-1] == f"next: robotid run {finished}"


def test_show_prints_an_axis_that_slides_in_its_units(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    file, text = Path("diagnosis.h5"), load(config, ["robot.linear=true"]).resolved_text()
    save(file, UNKNOWN, Provenance("diagnose", "robotid diagnose", {}, {}, text))
    assert main(["show", str(file)]) == 0
    out = capsys.readouterr().out
    assert "missing force [N]" in out
    assert "[Nm]" not in out


def test_show_prints_content_and_provenance(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["excite", config])
    table = capsys.readouterr().out
    assert main(["show", "runs/axis/excitation.h5"]) == 0
    out = capsys.readouterr().out
    assert out.startswith(table)
    assert "robotid excite axis.yaml, version" in out
    assert main(["show", "runs/axis/excitation.h5", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document["content"]["references"]) == ["slow"]
    assert "motor.viscous.Fv: 0.02" in document["provenance"]["configuration"]


def test_show_what_is_no_artifact(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "model.h5"
    path.write_text("not HDF5")
    assert main(["show", str(path)]) == 3
    assert capsys.readouterr() == (
        "",
        f"{path}: this is not a readable HDF5 file: foreign or damaged; run its stage again\n",
    )


def test_a_whole_run(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", config, "--json"]) == 0
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert [entry["ran"] for entry in document["stages"]] == [True] * (len(STAGES) + 1)
    assert document["validate"]["models"]["m1"]["records"]["slow"]["fit_percent"] > 95
    assert err.count(" written in ") == len(STAGES) + 1
    assert main(["run", config]) == 0
    out, err = capsys.readouterr()
    assert err.count(" is fresh\n") == len(STAGES) + 1
    assert "Fit [%]" in out


@pytest.mark.parametrize("command", ["run", "validate"])
def test_below_the_threshold_the_results_are_told_all_the_same(
    command: str, finished: str, capsys: pytest.CaptureFixture[str]
) -> None:
    demand = ["--set", "validate.thresholds.fit_percent.slow=99.999"]
    assert main([command, finished, *demand, "--json", "--quiet"]) == 5
    out, err = capsys.readouterr()
    document = json.loads(out)
    failed = document["failed"] if command == "validate" else document["validate"]["failed"]
    assert len(failed) == 1
    assert failed[0].startswith("m1 fits slow to 9")
    assert err.startswith(f"runs/axis/validation.h5: {failed[0]}; ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_has_a_view_of_its_own(stage: str, finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(Path("runs/axis") / STAGES[stage].output)
    assert STAGES[stage].tables.endswith(stage.replace("-", "_"))
    assert main(["show", file]) == 0
    assert "Provenance" in capsys.readouterr().out
    assert main([stage, finished, "--json", "--quiet"]) == 0
    alone = json.loads(capsys.readouterr().out)
    assert main(["show", file, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["content"] == alone
