"""Files that were recorded at the same time are one table, each with its time stamps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robotid.errors import InputError
from robotid.signals.joining import joined
from robotid.signals.measured import Selection, measured_records
from robotid.signals.readers import read
from robotid.signals.readers.table import Table

T = np.arange(1000) * 1e-3


def angle_table(**more: np.ndarray) -> Table:
    return Table("day/encoder.csv", {"time": T, "angle": np.sin(7 * T), **more})


def test_one_file_stays_as_it_is() -> None:
    table = angle_table()
    assert joined([table]) is table


def test_a_torque_in_another_file_is_held_onto_the_stamps_of_the_angle() -> None:
    t = 1e3 * (0.0505 + np.arange(400) * 2e-3)
    drive = Table("day/drive.csv", {"time_ms": t, "torque": np.floor(np.arange(400) / 10)})
    ((record, report),) = measured_records(Selection("a"), joined([angle_table(), drive]))
    start = np.searchsorted(T, 0.0505)
    np.testing.assert_allclose(record.phi_m, np.sin(7 * T[start : start + len(record)]), atol=1e-12)
    k = np.floor((T[start : start + len(record)] - 0.0505) / 2e-3 + 1e-6)
    np.testing.assert_array_equal(record.tau_m, np.floor(k / 10))
    assert "tau_m has time stamps of its own, time_ms: it is held onto time" in report.remarks


def test_names_that_come_twice_bear_their_file() -> None:
    other = Table("day/drive.csv", {"time": T, "angle": T, "torque": T})
    table = joined([angle_table(), other])
    assert set(table.columns) == {"encoder.time", "encoder.angle", "drive.time", "drive.angle", "torque"}
    assert table.clock("torque") == "drive.time"


def test_dates_of_both_files_are_counted_alike(tmp_path: Path) -> None:
    for name, first, column in (("a", 10, "angle"), ("b", 12, "torque")):
        rows = [f"2024-05-01 12:00:{first + k // 10}.{k % 10},{k}" for k in range(100)]
        (tmp_path / f"{name}.csv").write_text("\n".join([f"time,{column}", *rows]))
    table = joined([read(tmp_path / "a.csv"), read(tmp_path / "b.csv")])
    assert table.columns["b.time"][0] - table.columns["a.time"][0] == pytest.approx(2.0)


def test_a_file_without_time() -> None:
    with pytest.raises(InputError, match="there is no time column; files are joined by time"):
        joined([angle_table(), Table("drive.csv", {"torque": T})])


def test_files_of_different_days() -> None:
    later = Table("drive.csv", {"t": T + 100, "torque": np.sin(T)})
    with pytest.raises(InputError, match="were not recorded at the same time"):
        measured_records(Selection("a"), joined([angle_table(), later]))


def test_two_torques_are_asked_about() -> None:
    other = Table("drive.csv", {"time": T, "torque": T})
    with pytest.raises(Exception, match="could both be tau_m; say which under columns: tau_m"):
        measured_records(Selection("a"), joined([angle_table(torque=T), other]))
