"""The same columns come back from every format."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from robotid.signals.readers import read

T = np.arange(5) * 0.01
MATRIX = np.arange(15.0).reshape(5, 3)


@pytest.mark.parametrize(
    "text",
    [
        "t [s],phi [deg]\n0,1\n0.01,2.5\n",
        "\ufefft [s];phi [deg]\r\n0;1\r\n0,01;2,5\r\n",
        "t [s]\tphi [deg]\n0\t1\n1e-2\t2.5\n",
        "# robot 7\n\nt [s],phi [deg]\n0,1\n# break\n0.01,2.5\n",
    ],
    ids=["comma", "decimal comma, BOM", "tab", "comments"],
)
def test_text(text: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8", newline="")
    table = read(path)
    np.testing.assert_array_equal(table.columns["t"], [0, 0.01])
    np.testing.assert_array_equal(table.columns["phi"], [1, 2.5])
    assert table.units == {"t": "s", "phi": "deg"}


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


def test_hdf5_and_npz(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/t"] = T
        file["run/t"].attrs["unit"] = "s"
    np.savez(tmp_path / "a.npz", t=T, q=MATRIX)
    assert read(tmp_path / "a.h5").units == {"run.t": "s"}
    np.testing.assert_array_equal(read(tmp_path / "a.h5").columns["run.t"], T)
    np.testing.assert_array_equal(read(tmp_path / "a.npz").pick("q", 0), MATRIX[:, 0])
