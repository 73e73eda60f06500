"""The same columns come back from every format."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from robotid.errors import ConfigError, InputError
from robotid.signals.columns import find
from robotid.signals.readers import Table, delimited, formats, read

T = np.arange(5) * 0.01
MATRIX = np.arange(15.0).reshape(5, 3)


@pytest.mark.parametrize(
    "text",
    [
        "t [s],phi [deg]\n0,1\n0.01,2.5\n",
        "\ufefft [s];phi [deg]\r\n0;1\r\n0,01;2,5\r\n",
        "t [s]\tphi [deg]\n0\t1\n1e-2\t2.5\n",
        "# robot 7\n\nt [s],phi [deg]\n0,1\n# break\n0.01,2.5\n",
        "t [s]\tphi [deg]\n0\t1\n0,01\t2,5\n",
        "t (s),phi (deg)\n0,1\n0.01,2.5\n",
        "t [s]|phi [deg]\n0|1\n0.01|2.5\n",
        "t [s],phi [deg]\n0,1\n0.01,2.5\n0.02",
        "t / s,phi / deg\n0,1\n0.01,2.5\n",
        "t,phi\ns,deg\n0,1\n0.01,2.5\n",
        "t,phi\n[s],[deg]\n0,1\n0.01,2.5\n",
        "# t [s], phi [deg]\n0, 1\n0.01, 2.5\n",
        '"t [s]","phi [deg]"\n"0","1"\n"0.01","2.5"\n',
        "sep=;\nt [s];phi [deg]\n0;1\n0.01;2.5\n",
        "Logger 3000\nDate: today\n\nt [s],phi [deg]\n0,1\n0.01,2.5\n",
        "t [s],phi [deg],\n0,1,\n0.01,2.5,\n",
        "t [s],phi [deg]\n0,1,\n0.01,2.5 # note\n",
        "t [s],state,phi [deg]\n0,on,1\n0.01,off,2.5\n",
        ",t [s],phi [deg]\n0,0,1\n1,0.01,2.5\n",
    ],
    ids=[
        "comma",
        "decimal comma, BOM",
        "tab",
        "comments",
        "decimal comma, tab",
        "parentheses",
        "bar",
        "last line broken off",
        "slash",
        "line of units",
        "line of units in brackets",
        "names in a comment",
        "quoted",
        "spreadsheet",
        "preamble",
        "trailing delimiters",
        "trailing delimiter and note",
        "a column of words",
        "numbered rows",
    ],
)
def test_text(text: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8", newline="")
    table = read(path)
    np.testing.assert_array_equal(table.columns["t"], [0, 0.01])
    np.testing.assert_array_equal(table.columns["phi"], [1, 2.5])
    assert table.units == {"t": "s", "phi": "deg"}


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-8-sig", "utf-16"])
def test_letters_of_windows(encoding: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t [s],Stellgröße [V],phi [°]\n0,1,2\n1,2,3\n", encoding=encoding)
    assert read(path).units == {"t": "s", "Stellgröße": "V", "phi": "°"}


def test_blanks_between_columns(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.txt", MATRIX, header="t phi u")
    np.testing.assert_array_equal(read(tmp_path / "a.txt").columns["u"], MATRIX[:, 2])


def test_a_name_that_would_come_twice_keeps_its_unit(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,phi [deg],phi [rad]\n0,1,2\n1,2,3\n")
    table = read(tmp_path / "a.csv")
    assert list(table.columns) == ["t", "phi [deg]", "phi [rad]"]
    assert table.units == {"phi [deg]": "deg", "phi [rad]": "rad"}


@pytest.mark.parametrize("cell", ["", "NaN", "n/a", "null", "-"])
def test_ways_to_leave_a_cell_empty(cell: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f"t,phi\n0,1\n1,{cell}\n2,3\n")
    np.testing.assert_array_equal(read(tmp_path / "a.csv").columns["phi"], [1, np.nan, 3])


def test_an_empty_cell_is_a_missing_sample(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,phi,u\n0,,1\n1,2,\n", encoding="utf-8")
    table = read(path)
    np.testing.assert_array_equal(table.columns["phi"], [np.nan, 2])
    np.testing.assert_array_equal(table.columns["u"], [1, np.nan])


def test_lines_are_those_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("# x\nt,phi\n0,1\n\n# y\n1,2\n", encoding="utf-8")
    assert read(path).where(1) == f"{path}:6"


def test_matlab_5(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"rec": {"t": T, "q": MATRIX}, "comment": "text"})
    table = read(tmp_path / "a.mat")
    np.testing.assert_array_equal(table.pick("rec.t", None), T)
    np.testing.assert_array_equal(table.pick("rec.q", 1), MATRIX[:, 1])


def test_matlab_5_cells_and_arrays_of_structs(tmp_path: Path) -> None:
    cells = np.empty(2, dtype=object)
    cells[:] = [T, "text"]
    structs = np.zeros(2, dtype=[("q", object)])
    structs["q"] = [T, 2 * T]
    savemat(tmp_path / "a.mat", {"signals": structs, "cells": cells})
    table = read(tmp_path / "a.mat")
    assert set(table.columns) == {"signals.0.q", "signals.1.q", "cells.0"}
    np.testing.assert_array_equal(table.pick("signals.1.q"), 2 * T)


def test_a_log_of_simulink_has_its_time_stamps_beside_each_signal(tmp_path: Path) -> None:
    t, fine = np.arange(60) * 0.01, np.arange(120) * 0.005
    log = {"torque": {"time": fine, "data": np.sin(fine)}, "angle": {"time": t, "signals": {"values": np.cos(t)}}}
    savemat(tmp_path / "log.mat", {"logsout": log})
    found = read(tmp_path / "log.mat")
    assert found.clock("logsout.torque.data") == "logsout.torque.time"
    assert found.clock("logsout.angle.signals.values") == "logsout.angle.time"


def test_the_time_and_data_of_a_timeseries_may_be_written_large(tmp_path: Path) -> None:
    t, fine = np.arange(60) * 0.01, np.arange(120) * 0.005
    log = {"torque": {"Time": fine, "Data": np.sin(fine)}, "angle": {"Time": t, "Data": np.cos(t)}}
    savemat(tmp_path / "log.mat", {"logsout": log})
    found = read(tmp_path / "log.mat")
    assert found.clock("logsout.torque.Data") == "logsout.torque.Time"
    columns = [find(found, signal) for signal in ("tau_m", "phi_m")]
    assert [column and column.name for column in columns] == ["logsout.torque.Data", "logsout.angle.Data"]


def test_a_matrix_is_offered_by_its_columns(tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", {"tout": np.arange(60) * 0.01, "simout": np.ones((60, 3))})
    found = read(tmp_path / "log.mat")
    assert found.offer() == "it holds tout, simout[0] to simout[2]"
    for written in ("simout:1", "simout.1", "simout(:,1)", "simout(1)"):
        with pytest.raises(ConfigError, match=r"did you mean simout\[1\]\? Columns of a matrix are counted from 0"):
            found.pick(written)


def test_matlab_73_cells(tmp_path: Path) -> None:
    """Entries of a cell stand under #refs#, and the cell refers to them."""
    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for k in (1, 2):
            file[f"#refs#/{k}"] = k * T[None, :]
        file["q"] = np.array([[file["#refs#/1"].ref, file["#refs#/2"].ref]], dtype=h5py.ref_dtype)
        file["q"].attrs["MATLAB_class"] = np.bytes_(b"cell")
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + path.read_bytes()[512:])
    table = read(path)
    assert set(table.columns) == {"q.0", "q.1"}
    np.testing.assert_array_equal(table.pick("q.1"), 2 * T)


def test_matlab_73(tmp_path: Path) -> None:
    """As MATLAB writes it: user block, transposed, text and empty arrays as numbers."""
    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values, kind in (
            ("rec/t", T[None, :], b"double"),
            ("rec/q", MATRIX.T, b"double"),
            ("note", np.array([[104, 105]], dtype=np.uint16), b"char"),
            ("none", np.array([0, 0], dtype=np.uint64), b"double"),
        ):
            file[name] = values
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
        file["none"].attrs["MATLAB_empty"] = np.uint8(1)
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + path.read_bytes()[512:])
    table = read(path)
    assert set(table.columns) == {"rec.t", "rec.q"}
    np.testing.assert_array_equal(table.pick("rec.t", None), T)
    np.testing.assert_array_equal(table.pick("rec.q", 2), MATRIX[:, 2])


def test_fields_of_structured_arrays(tmp_path: Path) -> None:
    rows = np.zeros(5, dtype=[("t", float), ("phi", np.float32), ("note", "S3")])
    rows["t"], rows["phi"] = T, 2 * T
    np.savez(tmp_path / "a.npz", log=rows)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["log"] = rows
    for name in ("a.npz", "a.h5"):
        table = read(tmp_path / name)
        assert set(table.columns) == {"log.t", "log.phi"}
        np.testing.assert_allclose(table.pick("log.phi"), 2 * T, rtol=1e-6)


@pytest.mark.parametrize("axes", [(100, 6), (6, 100)])
def test_a_matrix_may_lie_either_way(axes: tuple[int, int]) -> None:
    matrix = np.arange(600.0).reshape(100, 6)
    table = Table("a.mat", {"q": matrix if axes == matrix.shape else matrix.T})
    np.testing.assert_array_equal(table.pick("q", 2), matrix[:, 2])


def test_every_suffix_has_one_reader() -> None:
    known = formats()
    plain = {".csv", ".tsv", ".txt", ".lvm", ".json", ".jsonl", ".ndjson", ".mat", ".h5", ".hdf5", ".npz"}
    extra = {".parquet", ".pq", ".mcap", ".db3"}
    assert set(known) == plain | extra | {".mf4", ".mdf"}
    assert len(known) == sum(len(module.SUFFIXES) for module in set(known.values()))


def test_hdf5_and_npz(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/t"] = T
        file["run/t"].attrs["unit"] = "s"
    np.savez(tmp_path / "a.npz", t=T, q=MATRIX)
    assert read(tmp_path / "a.h5").units == {"run.t": "s"}
    np.testing.assert_array_equal(read(tmp_path / "a.h5").columns["run.t"], T)
    np.testing.assert_array_equal(read(tmp_path / "a.npz").pick("q", 0), MATRIX[:, 0])


@pytest.mark.parametrize("zone", ["", "+02:00", "Z", "-0330"])
@pytest.mark.parametrize(("delimiter", "comma"), [(",", "."), (";", ",")])
def test_dates_as_pandas_writes_them(tmp_path: Path, zone: str, delimiter: str, comma: str) -> None:
    rows = [f"2024-05-01 23:59:59.{900 + k}000{zone}" if k < 100 else f"2024-05-02 00:00:00{zone}" for k in range(101)]
    lines = [delimiter.join([stamp, f"{k}.5".replace(".", comma)]) for k, stamp in enumerate(rows)]
    (tmp_path / "a.csv").write_text(
        "\n".join([f"Zeitstempel{delimiter}Drehmoment", *lines]).replace("59.", f"59{comma}" if comma == "," else "59.")
    )
    found = read(tmp_path / "a.csv")
    np.testing.assert_allclose(np.diff(found.columns["Zeitstempel"]), 1e-3, atol=1e-9)
    hours = {"": 0.0, "Z": 0.0, "+02:00": 2.0, "-0330": -3.5}[zone]
    assert found.origins["Zeitstempel"] == 1714607999 - 3600 * hours
    assert found.units["Zeitstempel"] == "s"


def test_an_index_of_dates_without_a_name(tmp_path: Path) -> None:
    rows = [f"2024-05-01 12:00:0{k},{k},{k}" for k in range(9)]
    (tmp_path / "a.csv").write_text("\n".join([",torque,angle", *rows]))
    np.testing.assert_array_equal(read(tmp_path / "a.csv").columns["time"], np.arange(9.0))


@pytest.mark.parametrize("bad", ["2024-13-01 12:00:00", "yesterday", "12:00:05"])
def test_what_is_no_date(tmp_path: Path, bad: str) -> None:
    rows = [f"2024-05-01 12:00:0{k},{k},{k}" for k in range(9)]
    rows[5] = f"{bad},5,5"
    (tmp_path / "a.csv").write_text("\n".join(["t,torque,angle", *rows]))
    with pytest.raises(InputError, match=f'"{bad}" is not a date') as error:
        read(tmp_path / "a.csv")
    assert error.value.where.endswith("a.csv:7")


@pytest.mark.parametrize(
    ("stamp", "origin"),
    [
        ("01.05.2024 12:00:0{k},500", 1714564800.0),
        ("2024/05/01 12:00:0{k}.500", 1714564800.0),
        ("12:00:0{k}.500", 43200.0),
    ],
)
def test_dates_as_people_write_them(stamp: str, origin: float, tmp_path: Path) -> None:
    rows = [f'"{stamp.format(k=k)}";{k},5;{k}' for k in range(9)]
    (tmp_path / "a.csv").write_text("\n".join(["Datum;Moment;Winkel", *rows]))
    found = read(tmp_path / "a.csv")
    np.testing.assert_allclose(found.columns["Datum"], np.arange(9.0) + 0.5)
    assert found.origins == {"Datum": origin}
    assert find(found, "t") is not None


def test_a_date_that_has_two_meanings_is_none(tmp_path: Path) -> None:
    rows = [f"01/05/2024 12:00:0{k},{k},{k}" for k in range(9)]
    (tmp_path / "a.csv").write_text("\n".join(["date,torque,angle", *rows]))
    assert set(read(tmp_path / "a.csv").columns) == {"torque", "angle"}


def test_decimal_commas_between_blanks(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("Zeit[s]   Moment[Nm]\n0,00   1,5\n0,01  -2,5\n0,02  1,5e-1\n")
    found = read(tmp_path / "a.txt")
    np.testing.assert_allclose(found.columns["Zeit"], [0.0, 0.01, 0.02])
    np.testing.assert_allclose(found.columns["Moment"], [1.5, -2.5, 0.15])


def test_rows_of_empty_cells_are_none(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t;torque\n0,00;1,5\n0,01;2,5\n\n;\n;\n")
    np.testing.assert_allclose(read(tmp_path / "a.csv").columns["t"], [0.0, 0.01])


def test_columns_without_names_go_by_their_positions(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("0,1.5,2\n0.1,1.6,2\n0.2,1.7,3\n")
    found = read(tmp_path / "a.csv")
    assert list(found.columns) == ["0", "1", "2"]
    np.testing.assert_array_equal(found.columns["1"], [1.5, 1.6, 1.7])


def test_a_position_counts_columns_of_text_too(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("state,t,u\nok,0,1\nok,1,2\nok,2,3\n")
    found = read(tmp_path / "a.csv")
    assert (found.at_position("2"), found.at_position("7"), found.at_position("u")) == ("u", "7", "u")


def test_a_long_text_is_read_some_lines_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "log.csv"
    rows = "\r\n".join(f"{0.001 * k:.3f};{k / 7:.4f}" + ("\r\n# pause" if k % 40 == 0 else "") for k in range(500))
    file.write_text(f"# a log\r\nt [s];tau\r\n{rows.replace('.', ',')}\r\n", newline="")
    whole = read(file)
    monkeypatch.setattr(delimited, "CHUNK", 1_000)
    parts = read(file)
    assert whole.lines is not None
    assert parts.lines is not None
    np.testing.assert_array_equal(parts.lines, whole.lines)
    for name in ("t", "tau"):
        np.testing.assert_array_equal(parts.pick(name), whole.pick(name))
    assert whole.pick("tau")[7] == 1.0
    assert whole.where(1).endswith("log.csv:5")


@pytest.mark.parametrize("row", ["{},{},x", "{},{},1"], ids=["words", "numbers"])
def test_a_last_line_that_breaks_off_is_left_out_and_said(row: str, tmp_path: Path) -> None:
    """A recorder that was switched off leaves such a line; one with its end is an error."""
    text = "t,phi,state\n" + "".join(row.format(k, k * k) + "\n" for k in range(9)) + "9,8"
    (tmp_path / "a.csv").write_text(text)
    table = read(tmp_path / "a.csv")
    assert len(table.columns["phi"]) == 9
    assert table.remarks == ("the last line breaks off after 2 of 3 columns, and is left out",)
    (tmp_path / "a.csv").write_text(text + "\n")
    with pytest.raises(InputError, match="2 columns where the names promise 3"):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize(
    "text",
    [
        't,phi\n"1,000.5","-1,234,567.25"\n"1,001.5",998.0\n',
        "t;phi\n1.000,5;-1.234.567,25\n1.001,5;998,0\n",
        "t;phi\n1,000.5;-1,234,567.25\n1,001.5;998.0\n",
    ],
)
def test_marks_between_thousands(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text)
    table = read(tmp_path / "a.csv")
    assert table.columns["t"] == pytest.approx([1000.5, 1001.5])
    assert table.columns["phi"] == pytest.approx([-1_234_567.25, 998.0])


def test_a_number_with_one_mark_has_two_meanings(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text('t,phi\n0.5,"998"\n1.5,"1,000"\n')
    with pytest.raises(InputError, match='"1,000" is not a number'):
        read(tmp_path / "a.csv")


def test_pairs_of_time_and_value_under_keys(tmp_path: Path) -> None:
    head = "Name\ttorque\tName\tangle\nUnit\tNm\tUnit\trad\n\n"
    (tmp_path / "a.csv").write_text(head + "0\t1\t0\t2\n1\t3\t1\t4\n")
    with pytest.raises(InputError, match="has a time column of its own") as caught:
        read(tmp_path / "a.csv")
    assert "one time column" in str(caught.value)


def test_a_struct_that_names_itself_as_dspace_writes_it(tmp_path: Path) -> None:
    signal = [("Name", object), ("Data", object)]
    y = np.empty((1, 2), dtype=signal)
    y[0] = [("Model Root/joint/torque", 2 * T), ("angle", 3 * T)]
    path = tmp_path / "a.mat"
    savemat(path, {"log": {"X": {"Name": "time", "Data": T}, "Y": y}})
    assert set(read(path).columns) == {"log.X.time.Data", "log.Y.torque.Data", "log.Y.angle.Data"}
    y[0, 1]["Name"] = "torque"
    savemat(path, {"log": {"Y": y}})
    assert set(read(path).columns) == {"log.Y.0.Data", "log.Y.1.Data"}


def test_hexadecimal_samples_are_refused_by_that(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,tau,phi\n0.0,0x0F7E,0xFFFF0001\n0.1,0x0F7F,0xFFFF0002\n")
    with pytest.raises(InputError, match='hexadecimal, "0x0F7E"'):
        read(path)


@pytest.mark.parametrize("units", ["ms;Nm;ms;deg\n", ""], ids=["units", "names alone"])
def test_times_that_stand_before_every_signal_are_one_column(units: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"Time;Torque;Time;Position\n{units}0;1;0;2\n2;3;2;4\n")
    table = read(path)
    assert list(table.columns) == ["Time", "Torque", "Position"]
    assert table.units == ({"Time": "ms", "Torque": "Nm", "Position": "deg"} if units else {})
    assert np.array_equal(table.pick("Time"), [0.0, 2.0])
    assert table.at_position("3") == "Position"
    path.write_text(f"Time;Torque;Time;Position\n{units}0;1;1;2\n2;3;3;4\n")
    with pytest.raises(InputError, match=r'two columns are called "Time", and differ; .* export one'):
        read(path)


def test_dates_that_stand_before_every_signal_are_one_column(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    first, second = "2024-05-01 10:00:00.000", "2024-05-01 10:00:00.250"
    path.write_text(f"Time;Torque;Time;Position\n{first};1;{first};2\n{second};3;{second};4\n")
    assert np.array_equal(read(path).pick("Time"), [0.0, 0.25])
    late = "2024-05-01 10:00:00.500"
    path.write_text(f"Time;Torque;Time;Position\n{first};1;{second};2\n{second};3;{late};4\n")
    with pytest.raises(InputError, match='two columns are called "Time", and differ'):
        read(path)
