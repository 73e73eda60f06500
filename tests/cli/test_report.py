"""`robotid report`: a page of whatever has run, and figures as files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from support.html_document import Document

from robotid.cli.app import main
from robotid.pipeline.table import STAGES

TEXT = """\
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - name: slow
    excite: {kind: triangle, amplitude: 20, period: 2, sampling_time: 0.005}
  - name: check
    role: validate
    excite: {kind: triangle, amplitude: 15, period: 1.5, sampling_time: 0.005}
plant:
  parameters: {motor.inertia.J: 0.01, motor.viscous.Fv: 0.02, motor.coulomb.Fc: 0.5}
  controller: {kind: speed, kp: 0.5, ki: 5}
  noise: {speed: 0.01}
"""
PAGE = Path("runs/axis/report.html")


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "axis.yaml").write_text(TEXT)
    return "axis.yaml"


def test_nothing_has_run(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", config]) == 3
    expected = "runs/axis: nothing to report: no stage has run; run `robotid run axis.yaml` first\n"
    assert capsys.readouterr() == ("", expected)
    assert not Path("runs").exists()


def test_after_every_stage_and_after_the_last(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    shown = []
    for stage in STAGES:
        assert main([stage, config, "--quiet"]) == 0
        capsys.readouterr()
        assert main(["report", config, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        shown.append(stage)
        assert found["shows"] == shown
        assert found["left_out"] == {}
        text = Document(PAGE.read_text()).text.replace("\u00a0", " ")
        assert found["summary"] in text
        assert all(f"robotid {name} axis.yaml" in text for name in shown)
    assert "held-out records" in found["summary"]
    assert PAGE.stat().st_size < 1_000_000


def test_a_page_is_made_when_what_it_shows_has_changed(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["excite", config, "--quiet"])
    assert main(["report", config]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Report\nanswer   2 reference signals for axis are ready")
    assert err.startswith("report: runs/axis/report.html written in ")
    assert " s (not made yet)\n" in err
    made = PAGE.read_bytes()
    assert main(["report", config]) == 0
    assert "report: runs/axis/report.html is fresh\n" in capsys.readouterr().err
    assert main(["report", config, "--force"]) == 0
    assert PAGE.read_bytes() == made
    main(["collect", config, "--quiet"])
    assert main(["report", config, "--dry-run"]) == 0
    assert "what it shows has changed" in capsys.readouterr().out
    assert PAGE.read_bytes() == made
    PAGE.write_text("mine")
    capsys.readouterr()
    assert main(["report", config]) == 0
    assert "(it is not a report of this program)" in capsys.readouterr().err


def test_what_is_stale_is_left_out_and_said(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    for stage in ("excite", "collect", "init-rigid"):
        main([stage, config, "--quiet"])
    change = ["--set", "init_rigid.cutoff=20"]
    capsys.readouterr()
    assert main(["report", config, *change, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["shows"] == ["excite", "collect"]
    assert found["left_out"] == {"rigid.h5": "configuration changed: init_rigid"}
    assert "Not shown here: rigid.h5 (configuration changed: init_rigid)." in Document(PAGE.read_text()).text
    assert main(["report", config, "--set", "plant.seed=9"]) == 3
    assert "nothing to report: excitation.h5 is stale (configuration changed: plant)" in capsys.readouterr().err


@pytest.mark.parametrize(("form", "start"), [("svg", b"<?xml"), ("pdf", b"%PDF"), ("png", b"\x89PNG")])
def test_figures_as_files(form: str, start: bytes, config: str, capsys: pytest.CaptureFixture[str]) -> None:
    for stage in ("excite", "collect"):
        main([stage, config, "--quiet"])
    capsys.readouterr()
    assert main(["report", config, "--figures", "paper", "--format", form, "--json", "--quiet"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert json.loads(out)["figures"] == [f"paper/record-slow.{form}", f"paper/record-check.{form}"]
    images = [file.read_bytes() for file in Path("paper").iterdir()]
    assert all(image.startswith(start) for image in images)
    assert len(images) == 2
    if form == "svg":
        assert all(b">motor speed [rad/s]<" in image for image in images)
    if form == "pdf":  # letters as TrueType, which is type 42
        assert all(b"/CIDFontType2" in image and b"/Type3" not in image for image in images)


@pytest.mark.parametrize("command", ["report", "show"])
def test_a_figure_has_the_size_that_is_asked_for(command: str, config: str, capsys: pytest.CaptureFixture[str]) -> None:
    for stage in ("excite", "collect"):
        main([stage, config, "--quiet"])
    file = Path("record-slow.png")
    ways = {
        "report": ["report", config, "--figures", ".", "--format", "png", "--quiet"],
        "show": ["show", "runs/axis/records.h5", "--plot", str(file)],
    }
    assert main([*ways[command], "--size", "88x60"]) == 0
    width, height = (int.from_bytes(file.read_bytes()[at : at + 4], "big") for at in (16, 20))
    assert (width, height) == pytest.approx((88 / 25.4 * 300, 60 / 25.4 * 300), abs=1)
    capsys.readouterr()
    for wrong in ("88", "88x", "0x10", "9999x10", "wide"):
        assert main([*ways[command], "--size", wrong]) == 2
        line = f'--size: "{wrong}" is no size of a figure; give width and height in millimetres, 20 to 2000,'
        assert line in capsys.readouterr().err


def test_a_format_that_cannot_be_drawn(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["excite", config, "--quiet"])
    assert main(["report", config, "--figures", "paper", "--format", "doc"]) == 2
    assert '--format: no figure can be written as "doc"; use png, svg, pdf\n' in capsys.readouterr().err
    assert not Path("paper").exists()


def test_quiet_is_quiet(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["excite", config, "--quiet"])
    assert main(["report", config, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert PAGE.exists()


def test_a_run_ends_with_the_page(finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    change = ["--set", "report.title=Axis one & two"]
    assert main(["run", finished, "--json", *change]) == 0
    out, _ = capsys.readouterr()
    assert [entry["stage"] for entry in json.loads(out)["stages"]] == [*STAGES, "report"]
    assert Document(PAGE.read_text()).text.startswith("Axis one & two")


def test_a_run_below_its_threshold_is_reported_too(finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    demand = ["--set", "validate.thresholds.fit_percent.slow=99.999"]
    assert main(["run", finished, "--quiet", *demand]) == 5
    assert "below the 99.999 % asked." in Document(PAGE.read_text()).text.replace("\u00a0", " ")


def test_status_lists_the_page(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    def row() -> list[str]:
        capsys.readouterr()
        assert main(["status", config]) == 0
        return next(line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("report"))

    main(["excite", config, "--quiet"])
    assert row()[1] == "absent"
    main(["report", config, "--quiet"])
    assert row()[1] == "fresh"
    main(["collect", config, "--quiet"])
    assert row()[1:6] == ["stale", "what", "it", "shows", "has"]
    capsys.readouterr()
    assert main(["status", config, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["report"]
    assert found == {"state": "stale", "why": "what it shows has changed", "file": "runs/axis/report.html"}


def test_a_run_directory_is_shown(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    for stage in ("excite", "collect", "init-rigid", "init-flex", "fit", "report"):
        main([stage, config, "--quiet"])
    capsys.readouterr()
    assert main(["show", "runs/axis"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "runs/axis"
    shown = [line.split()[:2] for line in lines if line.partition(" ")[0] in (*STAGES, "report")]
    files = ["excitation.h5", "records.h5", "rigid.h5", "flex.h5", "model.h5", "report.html"]
    assert [file for _, file in shown] == files
    last = next(k for k, line in enumerate(lines) if line.startswith("report"))
    assert lines[last].endswith("its answer is below")
    assert "simulates the motor speed" in " ".join(lines[last + 1 :])
    assert main(["show", "runs/axis", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found["artifacts"]) == ["excite", "collect", "init-rigid", "init-flex", "fit"]
    assert found["summary"].startswith("Model m1 of axis")


def test_a_directory_without_artifacts_or_as_a_figure(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty").mkdir()
    assert main(["show", "empty"]) == 3
    assert "empty: there is no artifact in this directory" in capsys.readouterr().err
    assert main(["show", "empty", "--plot", "a.png"]) == 2
    assert "empty: a run directory is not one figure; name an artifact in it" in capsys.readouterr().err
    assert not Path("a.png").exists()


def test_what_an_artifact_holds_is_named_in_words(config: str, capsys: pytest.CaptureFixture[str]) -> None:
    for stage in ("excite", "collect", "init-rigid"):
        main([stage, config, "--quiet"])
    capsys.readouterr()
    assert main(["show", "runs/axis/rigid.h5"]) == 0
    out = capsys.readouterr().out
    assert "holds" in out
    assert "First step: the rigid joint" in out
    assert "RigidResult" not in out
