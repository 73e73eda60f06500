"""Columns are guessed as a person would, and doubts are said."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.mistaken_logs import right_log
from support.paths import SHARED

from robotid.errors import InputError
from robotid.signals.columns import Column
from robotid.signals.proposal import Proposal, propose


def proposal(folder: Path, head: str, step: float = 0.001) -> Proposal:
    path = folder / "log.csv"
    width = head.count(",") + 1
    rows = [",".join([f"{k * step:.6g}", *[f"{k % 7}.5"] * (width - 1)]) for k in range(100)]
    path.write_text("\n".join([head, *rows]), encoding="utf-8")
    return propose(path)


def test_usual_names_leave_no_doubt(tmp_path: Path) -> None:
    found = proposal(tmp_path, "time [s],torque [Nm],angle [deg],speed [rpm],ref [rad]")
    assert found.columns == {
        "t": Column("time", unit="s"),
        "tau_m": Column("torque", unit="Nm"),
        "phi_m": Column("angle", unit="deg"),
        "dphi_m": Column("speed", unit="rpm"),
        "ref": Column("ref", unit="rad"),
    }
    assert (found.sampling_time, found.remarks) == (0.001, ())


@pytest.mark.parametrize(
    ("scale", "unit", "said"),
    [(1.0, "deg", "qg is taken to be in deg: angle follows its numbers"), (0.0175, None, "qg names no unit")],
)
def test_a_reference_without_a_unit_has_that_of_what_follows_it(
    tmp_path: Path, scale: float, unit: str | None, said: str
) -> None:
    t = np.arange(500) * 0.002
    motion = 40.0 * np.sin(5.0 * t)
    rows = zip(t, np.cos(5.0 * t), motion, scale * (motion + 0.5 * np.cos(20.0 * t)), strict=True)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time [s],torque [Nm],angle [deg],qg", *(",".join(map(str, row)) for row in rows)]))
    found = propose(path)
    assert found.columns["ref"] == Column("qg", unit=unit)
    assert [remark for remark in found.remarks if remark.startswith(said)]


def test_volts_want_a_scale(tmp_path: Path) -> None:
    found = proposal(tmp_path, "Time_ms,u_volt,EncoderPosition_deg", step=1)
    assert found.columns["t"] == Column("Time_ms", unit="ms")
    assert found.columns["tau_m"] == Column("u_volt", unit="V", scale=1.0)
    assert found.columns["phi_m"] == Column("EncoderPosition_deg", unit="deg")
    assert found.sampling_time == pytest.approx(0.001)
    assert "u_volt is in V; give the torque per V as scale" in found.remarks


def test_a_motor_comes_before_others(tmp_path: Path) -> None:
    found = proposal(tmp_path, "t,joint_pos,motor_pos,load_pos,pos_ref,tau")
    assert found.columns["phi_m"].name == "motor_pos"
    assert found.columns["phi_a"].name == "load_pos"
    assert found.columns["ref"].name == "pos_ref"
    assert "phi_m could also be joint_pos" in found.remarks


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    found = proposal(tmp_path, "a,b,c")
    assert found.columns == {}
    assert found.remarks == (
        "no column looks like tau_m; it holds a, b, c",
        "no column looks like phi_m; it holds a, b, c",
        "no time column was found; give sampling_time",
    )


def test_a_time_that_may_be_milliseconds(tmp_path: Path) -> None:
    found = proposal(tmp_path, "time,torque,angle", step=1)
    assert "time steps by 1; give its unit if it does not count seconds" in found.remarks


@pytest.mark.parametrize(
    ("head", "first", "tick", "unit", "scale"),
    [
        ("milliseconds since 1970", 1_714_560_000_000, 1e-3, "ms", None),
        ("microseconds since 1970", 1_714_560_000_000_000, 1e-6, "us", None),
        ("nanoseconds since 1970", 1_714_560_000_000_000_000, 1e-9, "ns", None),
        ("100 ns since 1601, as Windows does", 133_590_336_000_000_000, 1e-7, None, 1e-7),
    ],
)
def test_a_time_that_is_a_date(
    head: str, first: int, tick: float, unit: str | None, scale: float | None, tmp_path: Path
) -> None:
    step = round(0.002 / tick)
    rows = [f"{first + k * step},{k % 7}.5,{k % 5}.5" for k in range(100)]
    (tmp_path / "log.csv").write_text("\n".join(["Timestamp,torque,angle", *rows]))
    found = propose(tmp_path / "log.csv")
    assert found.columns["t"] == Column("Timestamp", unit=unit, scale=scale)
    assert found.sampling_time == pytest.approx(0.002, rel=1e-3)
    assert f"Timestamp counts {head}" in found.remarks


def test_seconds_are_left_as_they_are(tmp_path: Path) -> None:
    rows = [f"{1_714_560_000 + k * 0.002:.3f},{k % 7}.5,{k % 5}.5" for k in range(100)]
    (tmp_path / "log.csv").write_text("\n".join(["time,torque,angle", *rows]))
    assert propose(tmp_path / "log.csv").columns["t"] == Column("time")


@pytest.mark.parametrize(
    ("stamp", "said"),
    [
        (lambda k: "12:00:01", "the time column Time stands still"),
        (lambda k: f"12:00:{k // 50:02d}", "the time column Time has 4 times for 200 samples"),
        (lambda k: f"{300 - k}", "time runs backward in column Time"),
    ],
    ids=["still", "coarse", "backward"],
)
def test_why_a_time_column_tells_no_sampling_time(stamp: Callable[[int], str], said: str, tmp_path: Path) -> None:
    rows = [f"{stamp(k)};{k % 7}.5;{k % 5}.5" for k in range(200)]
    (tmp_path / "log.csv").write_text("\n".join(["Time;torque;angle", *rows]))
    assert f"{said}; give sampling_time" in propose(tmp_path / "log.csv").remarks


def test_a_speed_is_no_angle(tmp_path: Path) -> None:
    found = proposal(tmp_path, "time,torque,speed [rpm]")
    assert "no column looks like phi_m, and a speed alone is not enough; it holds time, torque, speed" in found.remarks


def test_numbers_at_the_end_of_words_are_no_part_of_them(tmp_path: Path) -> None:
    found = proposal(tmp_path, "%time,field.header.seq,field.position0,field.velocity0,field.effort0")
    assert {signal: column.name for signal, column in found.columns.items()} == {
        "t": "%time",
        "tau_m": "field.effort0",
        "phi_m": "field.position0",
        "dphi_m": "field.velocity0",
    }


def test_a_current_with_a_number_is_in_amperes(tmp_path: Path) -> None:
    found = proposal(tmp_path, "timestamp,actual_q_0,actual_qd_0,actual_current_0")
    assert found.columns["tau_m"] == Column("actual_current_0", unit="A", scale=1.0)
    assert "actual_current_0 is in A; give the torque per A as scale" in found.remarks


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "log.mat").write_text("no")
    with pytest.raises(InputError):
        propose(tmp_path / "log.mat")


def test_matrices_of_a_robot(tmp_path: Path) -> None:
    np.savez(
        tmp_path / "log.npz", t=np.arange(100) * 0.004, act_torque_nm=np.ones((6, 100)), act_pos_deg=np.ones((100, 6))
    )
    found = propose(tmp_path / "log.npz")
    assert found.columns["tau_m"] == Column("act_torque_nm", 0, "Nm")
    assert found.columns["phi_m"] == Column("act_pos_deg", 0, "deg")
    assert "act_pos_deg is a matrix, one column a joint; column 0 is proposed" in found.remarks


def test_kuka() -> None:
    path = SHARED / "kuka_kr300" / "A.mat"
    if not path.is_file():
        pytest.skip(f"{path} is not there: third-party data")
    found = propose(path)
    assert found.columns["phi_m"] == Column("rec.act_pos_mot_deg", 0, "deg")
    assert found.columns["dphi_m"] == Column("rec.act_vel_mot_deg_per_s", 0, "deg/s")
    assert found.sampling_time == 0.004


def test_emps() -> None:
    path = SHARED / "emps" / "DATA_EMPS.mat"
    if not path.is_file():
        pytest.skip(f"{path} is not there: third-party data")
    found = propose(path)
    assert {signal: column.name for signal, column in found.columns.items()} == {
        "t": "t",
        "tau_m": "vir",
        "phi_m": "qm",
        "ref": "qg",
    }
    assert found.sampling_time == 0.001


def test_a_column_that_never_changes_is_not_the_one(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = [f"{0.001 * k:.3f},0,{k % 7},{k % 5}" for k in range(100)]
    path.write_text("\n".join(["t,wrist_torque,elbow_torque,angle", *rows]))
    found = propose(path)
    assert found.columns["tau_m"].name == "elbow_torque"
    assert "wrist_torque could also be tau_m, and never changes" in found.remarks


def test_columns_without_names_are_guessed_by_their_values(tmp_path: Path) -> None:
    t = np.arange(500) * 0.002
    torque = np.sign(np.sin(9 * t)) + 0.1 * np.random.default_rng(1).normal(size=500)
    np.savetxt(tmp_path / "log.csv", np.column_stack([torque, np.sin(7 * t), t, 7 * np.cos(7 * t)]), delimiter=",")
    found = propose(tmp_path / "log.csv")
    assert {signal: column.name for signal, column in found.columns.items()} == {
        "t": "2",
        "tau_m": "0",
        "phi_m": "1",
        "dphi_m": "3",
    }
    assert "the file has no names: columns are guessed by their values, and units are SI" in found.remarks


def test_values_that_tell_nothing_are_left_out(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).normal(size=(300, 4))
    np.savetxt(tmp_path / "log.csv", noise, delimiter=",")
    assert propose(tmp_path / "log.csv").columns == {}


def test_columns_without_names_are_no_axes(tmp_path: Path) -> None:
    """Their numbers tell signals apart."""
    log = right_log("rigid")
    np.savetxt(tmp_path / "a.txt", np.column_stack([log[name] for name in ("t", "tau_m", "phi_m", "dphi_m")]))
    found = propose(tmp_path / "a.txt")
    assert {signal: column.name for signal, column in found.columns.items()} == {
        "t": "0",
        "tau_m": "1",
        "phi_m": "2",
        "dphi_m": "3",
    }
    assert found.axes == ()


@pytest.mark.parametrize("head", ["tiempo,par,posicion_rad,velocidad_rad_s", "时间,力矩,角度,速度"])
def test_names_in_other_languages(head: str, tmp_path: Path) -> None:
    found = proposal(tmp_path, head)
    assert [column.name for column in found.columns.values()] == head.split(",")
    assert list(found.columns) == ["t", "tau_m", "phi_m", "dphi_m"]
