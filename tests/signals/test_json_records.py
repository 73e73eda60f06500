"""JSON as loggers write it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robotid.errors import ConfigError, InputError
from robotid.signals.readers import Table, read


def written(tmp_path: Path, text: str, name: str = "a.jsonl") -> Table:
    path = tmp_path / name
    path.write_text(text)
    return read(path)


@pytest.mark.parametrize(
    "text",
    [
        '{"t": 0.0, "motor": {"tau": 1, "phi": 2.5}}\n{"t": 0.01, "motor": {"tau": null, "phi": 3.5}}\n',
        '{"t": 0.0, "motor": {"tau": 1, "phi": 2.5}}\n\n{"t": 0.01, "motor": {"phi": 3.5}}',
        '[{"t": 0.0, "motor": {"tau": 1, "phi": 2.5}},\n {"t": 0.01, "motor": {"phi": 3.5}}]',
        '{"rate": 100, "t": [0.0, 0.01], "motor": {"tau": [1, NaN], "phi": [2.5, 3.5]}}',
    ],
    ids=["null", "left out", "list of objects", "object of lists"],
)
def test_columns_by_dotted_names(text: str, tmp_path: Path) -> None:
    table = written(tmp_path, text)
    assert list(table.columns) == ["t", "motor.tau", "motor.phi"]
    assert np.array_equal(table.pick("t"), [0.0, 0.01])
    assert np.array_equal(table.pick("motor.tau"), [1.0, np.nan], equal_nan=True)
    assert np.array_equal(table.pick("motor.phi"), [2.5, 3.5])


def test_times_are_counted_from_the_first(tmp_path: Path) -> None:
    table = written(tmp_path, '{"t": 1714557600000000001}\n{"t": 1714557600000000004}\n')
    assert np.array_equal(table.pick("t"), [0.0, 3.0])
    dates = written(tmp_path, '{"t": "2024-05-01T10:00:00.000Z"}\n{"t": "2024-05-01T10:00:00.250Z"}\n')
    assert np.array_equal(dates.pick("t"), [0.0, 0.25])
    assert dates.units == {"t": "s"}
    assert dates.origins == {"t": 1714557600.0}


def test_words_are_told_as_text(tmp_path: Path) -> None:
    table = written(tmp_path, '{"x": 1, "state": "on"}\n{"x": 2, "state": "off"}\n')
    with pytest.raises(ConfigError, match='"state" holds text, such as "on"'):
        table.pick("state")


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ('{"t": 0}\n{"t": 1}\n{"t": \n', r"a\.jsonl:3: this is not readable as JSON"),
        ("[" * 100_000, "not readable as JSON"),
        ("", "not readable as JSON"),
        ("3", "holds no samples"),
        ("[]", "holds no samples"),
        ("[1, 2]", "holds no samples"),
        ('{"rate": 100}', "holds no samples"),
        ('{"t": [0, 1], "x": [1]}', "different lengths"),
        ('{"t": "on"}\n{"t": "off"}', "no column holds numbers"),
        ('{"t": 0}\n{"t": 1' + "0" * 400 + "}", "larger than any number"),
        ('{"t": 1' + "0" * 9000 + "}", "not readable as JSON"),
    ],
)
def test_what_is_refused_in_a_line(text: str, what: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=what):
        written(tmp_path, text)


def test_text_that_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(b'{"t": "\xff"}')
    with pytest.raises(InputError, match="UTF-8"):
        read(path)
