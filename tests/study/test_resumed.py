"""Studies that are begun again where they were left."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from study.trials.resumed import resumed


@dataclass(frozen=True)
class Toss:
    """A trial, and its result."""

    key: str
    value: int


def doubled(spec: Toss, folder: Path) -> Toss:
    assert folder.is_dir()
    return Toss(spec.key, 2 * spec.value)


def test_what_is_done_is_not_done_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.json").write_text('{"key": "a", "value": 7}')
    found = resumed([Toss("a", 1), Toss("b", 2)], tmp_path, 1, doubled, lambda toss: f"{toss.value} points")
    assert found == [{"key": "a", "value": 7}, {"key": "b", "value": 4}]
    assert capsys.readouterr().err == "1/1 b: 4 points\n"
    assert not list(tmp_path.glob("*.part"))
