"""A configuration to start from: it loads, it runs, and it overwrites nothing."""

from __future__ import annotations

import json
import os
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from support.mistaken_logs import right_log

from robotid.cli.app import main
from robotid.config.columns import ColumnSettings
from robotid.config.load import load, parse, parse_axes


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write_log(path: Path, head: str = "time_s;MotorAngle_deg;u_volt") -> None:
    """A motor of 0.01 kg m2 with friction, swung by 2.5 Nm per volt, in degrees."""
    t = np.arange(4000) * 1e-3
    speed = 10 * np.sin(2 * np.pi * t)
    torque = 0.01 * np.gradient(speed, t) + 0.02 * speed + 0.5 * np.sign(speed)
    angle = np.rad2deg(np.cumsum(speed) * 1e-3)
    path.parent.mkdir(exist_ok=True)
    rows = np.column_stack([t, angle, torque / 2.5])
    np.savetxt(path, rows, delimiter=";", header=head, comments="", fmt="%.6f")


def uncommented(text: str) -> str:
    """The template with every optional section switched on."""
    start = text.index("# init_rigid:")
    return text[:start] + "\n".join(line.removeprefix("# ") for line in text[start:].splitlines())


def test_a_virtual_robot_to_start_from(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new", "axis"]) == 0
    assert capsys.readouterr().out == ""
    config = load("axis.yaml").config
    assert config.robot.name == "axis"
    assert [r.role for r in config.records] == ["estimate", "estimate", "validate"]
    assert main(["excite", "axis.yaml", "--quiet"]) == 0


def test_the_comments_are_true() -> None:
    main(["new", "axis"])
    text = Path("axis.yaml").read_text()
    assert parse(uncommented(text)) == parse(text, overrides=["validate.thresholds.fit_percent.rich=90"])


def test_from_data_with_other_names_units_and_volts(capsys: pytest.CaptureFixture[str]) -> None:
    write_log(Path("data/log.csv"))
    assert main(["new", "mine", "--from-data", "data/log.csv"]) == 0
    out = capsys.readouterr().out
    assert "MotorAngle_deg" in out
    assert "0.001 s" in out
    record = load("mine.yaml").config.records[0]
    assert (record.name, record.file) == ("log", "data/log.csv")
    assert record.columns is not None
    assert record.columns.t == "time_s"
    assert record.columns.phi_m == ColumnSettings(name="MotorAngle_deg", unit="deg")
    assert record.columns.tau_m == ColumnSettings(name="u_volt", unit="V", scale=1.0)


def test_what_is_written_runs(capsys: pytest.CaptureFixture[str]) -> None:
    write_log(Path("log.csv"))
    main(["new", "mine", "--from-data", "log.csv"])
    for stage in ("excite", "collect", "init-rigid"):
        capsys.readouterr()
        assert main([stage, "mine.yaml", "--set", "records.log.columns.tau_m.scale=2.5", "--json", "--quiet"]) == 0
    found = json.loads(capsys.readouterr().out)["parameters"]
    assert found["motor.inertia.J"]["value"] == pytest.approx(0.01, rel=0.02)
    assert found["motor.coulomb.Fc"]["value"] == pytest.approx(0.5, rel=0.02)


def test_a_sliding_axis_is_told_by_its_units() -> None:
    write_log(Path("log.csv"), "t_s;position_mm;force_N")
    main(["new", "slide", "--from-data", "log.csv"])
    assert load("slide.yaml").config.robot.linear


def test_columns_that_nobody_can_guess_are_said(capsys: pytest.CaptureFixture[str]) -> None:
    write_log(Path("log.csv"), "a;b;c")
    assert main(["new", "mine", "--from-data", "log.csv"]) == 2
    line = "log.csv: no column looks like tau_m; say which by --column tau_m=NAME; it holds a, b, c\n"
    assert capsys.readouterr() == ("", line)
    assert not Path("mine.yaml").exists()
    chosen = [word for pair in ("t=a", "phi_m=1", "tau_m=c") for word in ("--column", pair)]
    assert main(["new", "mine", "--from-data", "log.csv", *chosen]) == 0
    assert main(["collect", "mine.yaml", "--quiet"]) == 0


GERMAN = "Zeitstempel;Winkel [Grad];Motorstrom_A"
NO_NAMES = ""


@pytest.mark.parametrize("head", [GERMAN, "Zeit [s];Grad;Drehmoment [Nm]", "temps_s;angle_deg;couple", NO_NAMES])
def test_what_is_written_for_any_header_collects(head: str) -> None:
    write_log(Path("log.csv"), head)
    if not head:
        Path("log.csv").write_text("".join(Path("log.csv").read_text().splitlines(keepends=True)[1:]))
    assert main(["new", "mine", "--from-data", "log.csv"]) == 0
    assert main(["collect", "mine.yaml", "--quiet"]) == 0


def test_without_a_time_column_the_step_is_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    write_log(Path("log.csv"), "number_of_nothing;angle_deg;torque")
    assert main(["new", "mine", "--from-data", "log.csv"]) == 2
    assert capsys.readouterr().err.endswith("such as --sampling-time 0.001\n")
    assert main(["new", "mine", "--from-data", "log.csv", "--sampling-time", "0.001"]) == 0
    assert main(["collect", "mine.yaml", "--quiet"]) == 0


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--column", "tau_m"], '--column: "tau_m" is no SIGNAL=NAME; such as --column tau_m=Torque\n'),
        (["--column", "tau=c"], '--column: there is no signal "tau"; did you mean tau_m?\n'),
        (["--column", "tau_m=d"], 'log.csv: there is no column "d"; it holds a, b, c\n'),
    ],
)
def test_a_wrong_choice_is_one_line(arguments: list[str], line: str, capsys: pytest.CaptureFixture[str]) -> None:
    write_log(Path("log.csv"), "a;b;c")
    assert main(["new", "mine", "--from-data", "log.csv", *arguments]) == 2
    assert capsys.readouterr() == ("", line)


@pytest.mark.parametrize(
    ("head", "change", "remark"),
    [
        (
            "time,torque,angle",
            {"phi_m": 180 / pi},
            "the encoder's steps are those of degrees: phi_m is taken to be in deg",
        ),
        ("time,torque,angle,speed", {"phi_m": 180 / pi}, "phi_m is taken to be in deg"),
        ("time,torque,angle,speed", {"dphi_m": 30 / pi}, "dphi_m is taken to be in rpm"),
        (
            "time,torque,angle,speed",
            {"phi_m": 180 / pi, "dphi_m": 30 / pi},
            "phi_m is taken to be in deg and dphi_m is taken to be in rpm",
        ),
        (
            "time,torque,angle,speed",
            {"dphi_m": 1.7},
            "dphi_m is left out and derived from phi_m: the speed is 1.7 times",
        ),
        ("time,torque,angle,speed", {"dphi_m": 0.0}, "dphi_m is left out and derived from phi_m: the speed is 0 rad/s"),
        (
            "time,torque,angle",
            {"tau_m": -1.0},
            "torque and motion have opposite signs: tau_m is taken with the other one",
        ),
    ],
)
def test_what_the_check_finds_is_put_right_or_left_out(
    head: str, change: dict[str, float], remark: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = {name: change.get(name, 1.0) * values[:1500] for name, values in right_log("rigid").items()}
    columns = list(log.values())[: head.count(",") + 1]
    np.savetxt("log.csv", np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.9g")
    assert main(["new", "mine", "--from-data", "log.csv"]) == 0
    assert remark in capsys.readouterr().out
    assert main(["check", "mine.yaml"]) == 0


def test_counts_want_a_scale_that_may_be_given(capsys: pytest.CaptureFixture[str]) -> None:
    log = {name: values[:1500] for name, values in right_log("rigid").items()}
    counts = np.rint(log["phi_m"] / (2 * pi) * 4096)
    rows = np.column_stack([log["t"], log["tau_m"], counts])
    np.savetxt("log.csv", rows, delimiter=",", header="time,torque,enc_counts", comments="", fmt="%.9g")
    assert main(["new", "mine", "--from-data", "log.csv"]) == 4
    assert capsys.readouterr().err.endswith("; say how many SI units one is, --scale phi_m=NUMBER\n")
    assert not Path("mine.yaml").exists()
    assert main(["new", "mine", "--from-data", "log.csv", "--scale", f"phi_m={2 * pi / 4096}"]) == 0
    assert "as scale" not in capsys.readouterr().out
    assert main(["check", "mine.yaml"]) == 0


@pytest.mark.parametrize(
    ("scale", "line"),
    [
        ("tau_m", '--scale: "tau_m" is no SIGNAL=NUMBER; such as --scale tau_m=0.12\n'),
        ("ref=2", '--scale: there is no column of "ref"; one of t, tau_m, phi_m\n'),
    ],
)
def test_a_wrong_scale_is_one_line(scale: str, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    write_log(Path("log.csv"))
    assert main(["new", "mine", "--from-data", "log.csv", "--scale", scale]) == 2
    assert capsys.readouterr() == ("", line)


def test_columns_that_make_no_sense_together_are_not_written(capsys: pytest.CaptureFixture[str]) -> None:
    log = {name: values[:1500] for name, values in right_log("rigid").items()}
    rows = np.column_stack([log["t"], log["phi_m"], log["phi_m"]])
    np.savetxt("log.csv", rows, delimiter=",", header="time,torque,angle", comments="", fmt="%.9g")
    assert main(["new", "mine", "--from-data", "log.csv"]) == 4
    line = capsys.readouterr().err
    assert line.startswith("log.csv: the torque is a copy of the motor angle")
    assert line.endswith("; say which column is what by --column SIGNAL=NAME\n")
    assert not Path("mine.yaml").exists()


def test_a_matrix_of_simulink_by_its_columns() -> None:
    log = {name: values[:1500] for name, values in right_log("rigid").items()}
    savemat("log.mat", {"tout": log["t"], "simout": np.column_stack([log["tau_m"], log["phi_m"]])})
    chosen = [word for pair in ("t=tout", "tau_m=simout[0]", "phi_m=simout[1]") for word in ("--column", pair)]
    assert main(["new", "mine", "--from-data", "log.mat", *chosen]) == 0
    assert main(["check", "mine.yaml"]) == 0


def test_nothing_is_overwritten(capsys: pytest.CaptureFixture[str]) -> None:
    Path("mine.yaml").write_text("precious")
    assert main(["new", "mine"]) == 2
    expected = "mine.yaml: this file exists; choose another NAME, or --force to overwrite it\n"
    assert capsys.readouterr() == ("", expected)
    assert Path("mine.yaml").read_text() == "precious"
    assert main(["new", "mine", "--force"]) == 0
    assert Path("mine.yaml").read_text().startswith("# mine: ")


@pytest.mark.parametrize(
    ("arguments", "code", "line"),
    [
        (["new", "my robot"], 2, 'new: "my robot" is no name; use letters, digits, _ and - only'),
        (["new", "a", "--from-data", "no.csv"], 3, "no.csv: there is no such file; give --from-data a recording"),
    ],
)
def test_what_cannot_be(arguments: list[str], code: int, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == code
    assert capsys.readouterr() == ("", line + "\n")
    assert not list(Path.cwd().glob("*.yaml"))


def write_axes(path: Path, names: str) -> None:
    """The log of two motors, one column each or in matrices, as the names say."""
    t = np.arange(4000) * 1e-3
    columns = [t]
    for hertz in (1.0, 0.7):
        speed = 10 * np.sin(2 * np.pi * hertz * t)
        columns += [0.01 * np.gradient(speed, t) + 0.02 * speed + 0.5 * np.sign(speed), np.cumsum(speed) * 1e-3]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=names, comments="", fmt="%.6f")


def test_several_axes_are_suggested(capsys: pytest.CaptureFixture[str]) -> None:
    write_axes(Path("arm.csv"), "time,joint1_torque,joint1_angle,joint2_torque,joint2_angle")
    assert main(["new", "arm", "--from-data", "arm.csv"]) == 0
    assert "the file holds 2 axes" in capsys.readouterr().err
    text = Path("arm.yaml").read_text()
    assert load("arm.yaml").config.records[0].columns.phi_m == "joint1_angle"
    block = text[text.index("# robot:") :]
    records = "records: [{name: arm, file: arm.csv, columns: {t: time}}]\n"
    axes = parse_axes("\n".join(line.removeprefix("# ") for line in block.splitlines()) + "\n" + records)
    first, second = (axis.records[0].columns for axis in axes.values())
    assert (first.tau_m, first.phi_m) == ("joint1_torque", "joint1_angle")
    assert (second.tau_m, second.phi_m) == ("joint2_torque", "joint2_angle")
    assert list(axes["a2"].records[0].signals) == ["a1"]


def test_matrices_of_one_width_are_several_axes(capsys: pytest.CaptureFixture[str]) -> None:
    t = np.arange(4000) * 1e-3
    speed = 10 * np.sin(2 * np.pi * np.outer(t, [1.0, 0.7, 0.3]))
    torque = 0.01 * np.gradient(speed, 1e-3, axis=0) + 0.02 * speed + 0.5 * np.sign(speed)
    savemat("arm.mat", {"t": t, "tau": torque, "q": np.cumsum(speed, axis=0) * 1e-3})
    assert main(["new", "arm", "--from-data", "arm.mat"]) == 0
    assert "the file holds 3 axes" in capsys.readouterr().err
    assert "columns: {tau_m: {name: tau, column: 2}, phi_m: {name: q, column: 2}}" in Path("arm.yaml").read_text()


def test_one_pair_of_columns_is_one_axis(capsys: pytest.CaptureFixture[str]) -> None:
    write_axes(Path("arm.csv"), "time,torque_1,angle_1,torque_2,pressure")
    assert main(["new", "arm", "--from-data", "arm.csv"]) == 0
    assert "axes" not in capsys.readouterr().err
    assert "axes" not in Path("arm.yaml").read_text()


def test_a_file_whose_name_is_no_text(capsys: pytest.CaptureFixture[str]) -> None:
    name = Path(os.fsdecode(b"l\xf6g.csv"))
    try:
        write_log(name)
    except OSError:
        pytest.skip("the file system takes text only")
    assert main(["new", "axis", "--from-data", str(name)]) == 3
    assert capsys.readouterr().err == (
        "l\\xf6g.csv: no configuration can name this file, its name is not UTF-8; rename it\n"
    )
    assert not Path("axis.yaml").exists()


def test_two_files_of_one_recording_are_joined_by_time(capsys: pytest.CaptureFixture[str]) -> None:
    log = right_log("rigid")
    t = np.arange(0.0, log["t"][-1], 0.001)
    angle = np.interp(t, log["t"], log["phi_m"])
    np.savetxt("encoder.csv", np.column_stack([t, angle]), delimiter=",", header="time,pos_rad", comments="")
    drive = np.column_stack([log["t"], log["tau_m"]])
    np.savetxt("drive.csv", drive, delimiter=",", header="time,torque_Nm", comments="")
    assert main(["new", "two", "--from-data", "encoder.csv", "--from-data", "drive.csv"]) == 0
    assert "encoder.csv + drive.csv" in capsys.readouterr().out
    assert load(Path("two.yaml")).config.records[0].files == ("encoder.csv", "drive.csv")
    for stage in ("collect", "init-rigid"):
        assert main([stage, "two.yaml", "--quiet"]) == 0
    capsys.readouterr()
    assert main(["init-rigid", "two.yaml", "--json"]) == 0
    inertia = json.loads(capsys.readouterr().out)["parameters"]["motor.inertia.J"]["value"]
    assert inertia == pytest.approx(0.012, rel=0.05)


def test_the_second_of_two_files_must_exist(capsys: pytest.CaptureFixture[str]) -> None:
    write_log(Path("log.csv"))
    assert main(["new", "two", "--from-data", "log.csv", "--from-data", "drive.csv"]) == 3
    assert capsys.readouterr().err == "drive.csv: there is no such file; give --from-data a recording\n"


def test_turns_in_french() -> None:
    log = right_log("rigid")
    rows = np.column_stack([log["t"], log["tau_m"], log["phi_m"] / (2 * pi)])
    head = "temps (s);couple moteur (Nm);position moteur (tr)"
    np.savetxt("essai.csv", rows, delimiter=";", header=head, comments="")
    assert main(["new", "axe", "--from-data", "essai.csv"]) == 0
    column = load(Path("axe.yaml")).config.records[0].columns.phi_m
    assert isinstance(column, ColumnSettings)
    assert column.unit == "rev"
