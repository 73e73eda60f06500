"""Files become records in SI, and what was done to them is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.paths import SHARED

from robotid.config.records import RecordSettings
from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.quality import Report
from robotid.signals.readers import read
from robotid.signals.readers.table import Table
from robotid.signals.record import Record
from robotid.stages.ingestion.measured import measured_records

H = 1e-3
T = np.arange(2000) * H
SPEED = 10 * np.cos(2 * np.pi * T) + 2 * np.cos(40 * np.pi * T)
ANGLE = 10 * np.sin(2 * np.pi * T) / (2 * np.pi) + 2 * np.sin(40 * np.pi * T) / (40 * np.pi)
TORQUE = 0.02 * np.gradient(SPEED, H)


def record(table: Table, *, linear: bool = False, **settings: Any) -> tuple[Record, Report]:
    chosen = RecordSettings.model_validate({"name": "a", "file": "a.csv", **settings})
    ((found, report),) = measured_records(chosen, table, linear=linear)
    return found, report


def table(**columns: Array) -> Table:
    return Table("a.csv", {"t": T, "tau_m": TORQUE, "phi_m": ANGLE, **columns})


def test_the_log_of_a_stranger(tmp_path: Path) -> None:
    """Degrees, volts, milliseconds, decimal commas, German names, a line of units, Windows' letters."""
    path = tmp_path / "log.csv"
    rows = [f"{1e3 * t:.3f};{u / 2.5:.6f};{np.rad2deg(x):.6f};ok" for t, u, x in zip(T, TORQUE, ANGLE, strict=True)]
    head = ["Prüfstand 3", "", "Zeit;Stellgröße;Winkel;Zustand", "ms;V;°;-"]
    path.write_text("\r\n".join([*head, *(row.replace(".", ",") for row in rows)]), encoding="cp1252", newline="")
    columns = {"tau_m": {"name": "Stellgröße", "scale": 2.5}}
    found, report = record(read(path), columns=columns)
    assert found.sampling_time == H
    np.testing.assert_allclose(found.tau_m, TORQUE, atol=2e-6)
    np.testing.assert_allclose(found.phi_m, ANGLE, atol=2e-8)
    assert report.remarks == (
        "t is column Zeit in ms, found by its name",
        "tau_m is 2.5 Nm per V of column Stellgröße",
        "phi_m is column Winkel in deg, found by its name",
        "dphi_m is derived from phi_m by central differences",
    )


def test_a_derived_speed() -> None:
    found, _ = record(table())
    assert np.abs(found.dphi_m - SPEED)[1:-1].max() < 0.006


def test_a_sampling_time_comes_before_a_time_column_that_nobody_named() -> None:
    found, report = record(table(), sampling_time=0.002)
    assert found.sampling_time == 0.002
    remark = "t is column t, not used, for sampling_time is given"
    assert report.remarks[0] == f"{remark}: 0.002 s, where the column has {H:g} s between two samples; is that right?"
    _, report = record(table(), sampling_time=H)
    assert report.remarks[0] == remark


def test_a_column_that_is_said_to_be_none_is_not_looked_for() -> None:
    found, report = record(table(dphi_m=SPEED), columns={"dphi_m": None})
    assert np.any(found.dphi_m != SPEED)
    assert report.remarks[-1] == "dphi_m is derived from phi_m by central differences"


def test_a_late_speed_is_noticed_and_advanced() -> None:
    late = table(dphi_m=np.concatenate([[SPEED[0]] * 3, SPEED[:-3]]))
    _, report = record(late)
    notice = "dphi_m is 3.0 samples late against the derivative of phi_m; speed_delay: 3 or dphi_m: null removes it"
    assert report.remarks[-1] == notice
    found, report = record(late, speed_delay=3)
    assert report.remarks[-1] == "dphi_m is advanced by speed_delay: 3"
    np.testing.assert_array_equal(found.dphi_m, SPEED[:-3])
    np.testing.assert_array_equal(found.phi_m, ANGLE[:-3])


def test_an_early_speed_is_delayed() -> None:
    found, _ = record(table(dphi_m=np.concatenate([SPEED[2:], [SPEED[-1]] * 2])), speed_delay=-2)
    np.testing.assert_array_equal(found.dphi_m, SPEED[2:])
    np.testing.assert_array_equal(found.phi_m, ANGLE[2:])


@pytest.mark.parametrize(("factor", "written"), [(1.05, "1.05"), (180 / np.pi, "57.3"), (-1.0, "-1")])
def test_a_speed_of_another_scale_is_remarked(factor: float, written: str) -> None:
    assert f"dphi_m is {written} times the derivative of phi_m; is one of them scaled wrong?" in (
        record(table(dphi_m=factor * SPEED))[1].remarks
    )


def test_start_and_stop_cut_before_flaws_are_looked_for() -> None:
    torque = TORQUE.copy()
    torque[:100] = np.nan
    found, _ = record(table(tau_m=torque, t=1e3 + T), start=0.1, stop=0.899)
    np.testing.assert_array_equal(found.phi_m, ANGLE[100:900])
    assert len(record(table(), sampling_time=H, start=0.5)[0]) == 1500


@pytest.mark.parametrize(
    ("ref", "unit", "kind"),
    [
        (ANGLE + 0.01, None, "position"),
        (SPEED + 0.1, None, "speed"),
        (np.zeros(2000), "rpm", "speed"),
        (SPEED, "deg", "position"),
    ],
)
def test_kind_of_reference(ref: Array, unit: str | None, kind: str) -> None:
    found, _ = record(table(ref=ref), columns={"ref": {"name": "ref", "unit": unit}})
    assert found.ref_kind == kind


def test_counts_are_no_turns() -> None:
    """An angle in counts is scaled to radians; what looks like a turn of counts is not unwrapped."""
    counts = np.rint(ANGLE * 65536 / (2 * np.pi))
    found, report = record(table(phi_m=counts), columns={"phi_m": {"name": "phi_m", "scale": 2 * np.pi / 65536}})
    assert report.wraps == 0
    np.testing.assert_allclose(found.phi_m, ANGLE, atol=1e-4)
    assert report.quantum == pytest.approx(2 * np.pi / 65536, rel=1e-6)


def test_an_arm_angle_that_wraps_is_unwrapped_before_the_gear() -> None:
    """The joint's angle in degrees, wrapped, times the gear ratio is the motor's."""
    joint = np.rad2deg(ANGLE) + 150
    wrapped = (joint + 180) % 360 - 180
    found, report = record(table(phi_m=wrapped), columns={"phi_m": {"name": "phi_m", "unit": "deg", "scale": 100.0}})
    assert report.wraps > 0
    np.testing.assert_allclose(np.diff(found.phi_m), 100 * np.diff(ANGLE), atol=1e-9)


def test_a_sliding_axis_does_not_wrap() -> None:
    jumping = (ANGLE + 3) % 6
    assert record(table(phi_m=jumping), linear=True)[1].wraps == 0


@pytest.mark.parametrize("kind", ["A", "B"])
def test_kuka_speed_is_a_sample_late(kind: str) -> None:
    path = SHARED / "kuka_kr300" / f"{kind}.mat"
    if not path.is_file():
        pytest.skip(f"{path} is not there: third-party data")
    columns = {
        "tau_m": {"name": "rec.act_torque_abs_nm", "column": 0},
        "phi_m": {"name": "rec.act_pos_mot_deg", "column": 0, "unit": "deg"},
        "dphi_m": {"name": "rec.act_vel_mot_deg_per_s", "column": 0, "unit": "deg/s"},
    }
    found, report = record(read(path), columns=columns, sampling_time=0.004)
    assert (len(found), found.sampling_time) == (2501, 0.004)
    assert "late against the derivative of phi_m; speed_delay: 1 or dphi_m: null" in report.remarks[-1]
    _, report = record(read(path), columns=columns, sampling_time=0.004, speed_delay=1)
    assert report.remarks == ("dphi_m is advanced by speed_delay: 1",)


def test_emps() -> None:
    path = SHARED / "emps" / "DATA_EMPS.mat"
    if not path.is_file():
        pytest.skip(f"{path} is not there: third-party data")
    columns = {"tau_m": {"name": "vir", "scale": 35.15065}}
    found, report = record(read(path), linear=True, columns=columns)
    assert (len(found), found.sampling_time, found.ref_kind) == (24841, 0.001, "position")
    assert report.quantum == pytest.approx(5e-8, rel=1e-3)
    assert report.jitter < 1e-3
    assert "phi_m is column qm, found by its name" in report.remarks
    assert "ref is column qg, found by its name" in report.remarks


def all_records(table: Table, **settings: Any) -> tuple[tuple[Record, Report], ...]:
    chosen = RecordSettings.model_validate({"name": "a", "file": "a.csv", **settings})
    return measured_records(chosen, table, linear=False)


def test_gaps_beyond_repair_cut_the_record() -> None:
    kept = np.concatenate([np.arange(0, 700), np.arange(800, 820), np.arange(1000, 2000)])
    found = all_records(Table("a.csv", {"t": T[kept], "tau_m": TORQUE[kept], "phi_m": ANGLE[kept]}))
    assert [(r.name, r.experiment, len(r)) for r, _ in found] == [("a_1", "a", 700), ("a_2", "a", 1000)]
    np.testing.assert_array_equal(found[1][0].phi_m, ANGLE[1000:])
    sentence = (
        "2 gaps, the first before a.csv, sample 700, cut the record into a_1 and a_2; "
        "20 samples of parts that are too short or at rest are left out"
    )
    assert [report.remarks[0] for _, report in found] == [sentence] * 2


def test_a_cut_record_may_be_asked_to_be_whole() -> None:
    kept = np.concatenate([np.arange(0, 700), np.arange(710, 2000)])
    table = Table("a.csv", {"t": T[kept], "tau_m": TORQUE[kept], "phi_m": ANGLE[kept]})
    ((found, report),) = all_records(table, repair={"gaps": "interpolate"})
    assert (found.name, len(found), report.missing) == ("a", 2000, 10)


def test_jitter_is_stated_with_what_it_would_have_cost() -> None:
    rng = np.random.default_rng(3)
    t = T + 0.1 * H * rng.uniform(-1, 1, len(T))
    angle = 10 * np.sin(2 * np.pi * t) / (2 * np.pi) + 2 * np.sin(40 * np.pi * t) / (40 * np.pi)
    found, report = record(table(t=t, phi_m=angle))
    remark = next(remark for remark in report.remarks if "jitter" in remark)
    assert remark.startswith("sampling intervals jitter by 0.08")
    assert (
        "(20 %) at most: resampled on the time stamps, every 1 ms; ignored, the jitter would be an error of" in remark
    )
    first = np.argmin(np.abs(T - T[np.argmin(np.abs(ANGLE[:300] - found.phi_m[0]))]))
    exact = np.arange(len(found)) * H + T[first]
    speed = 10 * np.cos(2 * np.pi * exact) + 2 * np.cos(40 * np.pi * exact)
    assert np.abs(found.dphi_m - speed)[1:-1].max() < 0.03
    ignored, _ = record(table(phi_m=angle), sampling_time=H)
    cost = float(remark.split("an error of ")[1].split()[0])
    assert cost == pytest.approx(np.sqrt(np.mean((ignored.dphi_m - SPEED) ** 2)), rel=0.15)
    assert cost > 0.25


def test_a_sample_that_was_written_late_is_moved_to_its_time() -> None:
    order = np.arange(len(T))
    order[[500, 501]] = [501, 500]
    found, report = record(Table("a.csv", {"t": T[order], "tau_m": TORQUE[order], "phi_m": ANGLE[order]}))
    np.testing.assert_array_equal(found.phi_m, ANGLE)
    assert "1 sample stood out of order and was moved in time, the first at a.csv, sample 501" in report.remarks


def test_a_clock_that_was_set_back_is_refused() -> None:
    t = T.copy()
    t[1000:] -= 2.5 * H
    with pytest.raises(InputError, match="time runs backward"):
        record(table(t=t))


def test_a_disturbance_is_read_in_si() -> None:
    pulses = np.where(T % 0.5 < 0.1, 2.0, 0.0)
    found, _ = record(table(pulses=pulses), columns={"disturbance": {"name": "pulses", "unit": "V", "scale": 1.5}})
    assert found.disturbance is not None
    np.testing.assert_array_equal(found.disturbance, 1.5 * pulses)
    np.testing.assert_array_equal(found.piece(100, 300).disturbance, 1.5 * pulses[100:300])
    assert record(table())[0].disturbance is None
