"""`watch`: an accepted model against new logs, from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from support.watched_axis import write_accepted_run

from robotid.cli import progress
from robotid.cli.app import main


@pytest.fixture(scope="module")
def accepted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a fitted run, and two new logs: one of the same machine, one with more friction."""
    folder = tmp_path_factory.mktemp("watched")
    write_accepted_run(folder)
    return folder


def watch(folder: Path, *arguments: str) -> int:
    return main(["watch", str(folder / "a.yaml"), "--out", str(folder / "run"), *arguments])


def test_an_unchanged_log_is_exit_code_0_and_a_changed_one_5(
    accepted: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monday, friday = (str(accepted / f"{name}.csv") for name in ("monday", "friday"))
    assert watch(accepted, monday, "--quiet") == 0
    assert capsys.readouterr() == ("", "")
    assert watch(accepted, monday, friday, "--json") == 5
    shown = capsys.readouterr()
    found = json.loads(shown.out)
    assert found["alarm"] is True
    assert {name: log["state"] for name, log in found["logs"].items()} == {"monday": "unchanged", "friday": "changed"}
    assert found["logs"]["friday"]["change"]["parameter"] == "motor.coulomb.Fc"
    assert found["logs"]["monday"]["change"] is None
    assert "friday: motor.coulomb.Fc has changed by 0.0" in shown.err


def test_progress_says_what_is_at_work(
    accepted: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "LINE_INTERVAL", -1.0)
    assert watch(accepted, str(accepted / "monday.csv")) == 0
    assert "\nwatch: comparing monday, " in f"\n{capsys.readouterr().err}"


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        (("none.csv",), 3, "none.csv: there is no such file; check the path"),
        (("monday.csv", "--like", "three"), 2, 'no record "three" with a file'),
        (("monday.csv", "--model", "no"), 2, 'no model "no"'),
        (("monday.csv", "--level", "2"), 2, "--level"),
    ],
)
def test_what_cannot_be_watched_is_refused(
    arguments: tuple[str, ...],
    code: int,
    complaint: str,
    accepted: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(accepted)
    assert watch(accepted, *arguments) == code
    assert complaint in capsys.readouterr().err


def test_without_a_run_there_is_nothing_to_watch(
    accepted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = str(accepted / "monday.csv")
    assert main(["watch", str(accepted / "a.yaml"), log, "--out", str(tmp_path / "none")]) == 3
    assert "records.h5" in capsys.readouterr().err
