"""Files for other programs: what is written comes back, and a file is whole or as it was."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from robotid.errors import ConfigError, InputError
from robotid.export.write import check_format, write_columns, write_tree
from robotid.signals.readers import read

TREE = {
    "A": np.array([[1.0, 2.0], [3.0, 4.0]]),
    "names": ("twist", "motor speed"),
    "none": (),
    "unit": "rad/s",
    "day-2": {"1st": 1.5, "std": float("nan"), "fixed": True, "count": 3},
}


def test_matlab(tmp_path: Path) -> None:
    write_tree(tmp_path / "a.mat", TREE)
    found = loadmat(tmp_path / "a.mat", squeeze_me=True)
    np.testing.assert_array_equal(found["A"], TREE["A"])
    assert found["names"].tolist() == ["twist", "motor speed"]
    assert found["none"].size == 0
    assert found["unit"] == "rad/s"
    inner = found["day_2"]
    assert inner["x1st"] == 1.5
    assert np.isnan(float(inner["std"]))
    assert inner["fixed"] == 1


def test_json(tmp_path: Path) -> None:
    write_tree(tmp_path / "a.json", TREE)
    found = json.loads((tmp_path / "a.json").read_text())
    assert found["A"] == [[1, 2], [3, 4]]
    assert found["names"] == ["twist", "motor speed"]
    assert found["day-2"] == {"1st": 1.5, "std": None, "fixed": True, "count": 3}


def test_columns_come_back_to_the_last_digit(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    values = rng.standard_normal(50) * 10.0 ** rng.integers(-300, 300, 50)
    write_columns(tmp_path / "a.csv", {"t [s]": np.arange(50) * 0.1, "phi [deg]": values, "word": ["a, b"] * 50})
    table = read(tmp_path / "a.csv")
    np.testing.assert_array_equal(table.columns["phi"], values)
    assert table.units == {"t": "s", "phi": "deg"}
    assert table.text == {"word": "a, b"}


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("a.mta", "did you mean .mat?"),
        ("a.fmu", "use .mat, .json, .csv"),
        ("a.xlsx", "use .mat, .json, .csv"),
        ("a", "use .mat"),
    ],
)
def test_a_format_that_nobody_writes(name: str, hint: str) -> None:
    with pytest.raises(ConfigError, match=r"nothing is exported as") as error:
        check_format(Path(name))
    assert error.value.hint.startswith(hint)


def test_a_file_is_whole_or_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_tree(tmp_path / "a.json", {"first": 1})

    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(InputError, match="cannot be written: No space left on device"):
        write_tree(tmp_path / "a.json", {"second": 2})
    assert [file.name for file in tmp_path.iterdir()] == ["a.json"]
    assert json.loads((tmp_path / "a.json").read_text()) == {"first": 1}
