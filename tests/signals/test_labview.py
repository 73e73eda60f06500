"""Measurement files of LabVIEW."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robotid.errors import InputError
from robotid.signals.columns import find
from robotid.signals.readers import Table, read

HEAD = "LabVIEW Measurement\nSeparator\tTab\nX_Columns\t{columns}\n***End_of_Header***\t\n\t\nChannels\t2\n"
SIGNALS = "Y_Unit_Label\tNm\tdeg\nX0\t{begin}\t0\nDelta_X\t0.002\t0.002\n***End_of_Header***\t\t\n"
NAMES = "X_Value\tTorque\tAngle\tComment\n"


def written(tmp_path: Path, rows: str, columns: str = "One", begin: str = "0.5") -> Table:
    path = tmp_path / "a.lvm"
    path.write_text(HEAD.format(columns=columns) + SIGNALS.format(begin=begin) + NAMES + rows)
    return read(path)


@pytest.mark.parametrize(
    "rows", ["0.0\t1.5\t7\tstart\n0.002\t2.5\t8\n", "0,0\t1,5\t7\n0,002\t2,5\t8\n"], ids=["point", "comma"]
)
def test_names_and_units_of_the_header(rows: str, tmp_path: Path) -> None:
    table = written(tmp_path, rows)
    assert table.units == {"time": "s", "Torque": "Nm", "Angle": "deg"}
    found = [find(table, signal) for signal in ("t", "tau_m", "phi_m")]
    assert [one and one.name for one in found] == ["time", "Torque", "Angle"]
    assert np.array_equal(table.pick("time"), [0.0, 0.002])
    assert np.array_equal(table.pick("Torque"), [1.5, 2.5])
    assert table.where(1) == f"{tmp_path / 'a.lvm'}:13"


def test_times_that_the_header_tells(tmp_path: Path) -> None:
    table = written(tmp_path, "\t1.5\t7\n\t2.5\t8\n\t3.5\t9\n", "No")
    assert table.pick("time") == pytest.approx([0.5, 0.502, 0.504])
    with pytest.raises(InputError, match="the header has no X0"):
        written(tmp_path, "\t1.5\t7\n\t2.5\t8\n", "No", "later")


@pytest.mark.parametrize("columns", ["One", "No"])
def test_of_several_recordings_the_first_is_read_and_the_others_are_told(columns: str, tmp_path: Path) -> None:
    time = {"One": ("0", "0.002"), "No": ("", "")}[columns]
    again = "\t\nChannels\t2\n" + SIGNALS.format(begin="9") + NAMES + "9\t4\t6\n"
    table = written(tmp_path, f"{time[0]}\t1.5\t7\n{time[1]}\t2.5\t8\n" + again + again, columns, "0")
    assert np.array_equal(table.pick("time"), [0.0, 0.002])
    assert np.array_equal(table.pick("Torque"), [1.5, 2.5])
    assert table.remarks == ("the first of 3 recordings is read; the others, from line 15, are left out",)


def test_what_is_refused_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="times of its own"):
        written(tmp_path, "0\t1\t2\n", "Multi")
    again = "0\t1\t2\n" + SIGNALS.format(begin="9") + NAMES + "9\t1\t2\n"
    with pytest.raises(InputError, match="several recordings"):  # whose headers do not tell where they begin
        written(tmp_path, again)
    other = tmp_path / "b.lvm"
    other.write_text("t,tau\n0,1\n")
    with pytest.raises(InputError, match="no measurement file of LabVIEW"):
        read(other)
