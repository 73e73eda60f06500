"""`rid.compare` and `rid.watch`: what the commands find, in Python."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from support.watched_axis import TRUTH, axis_record, write_accepted_run

import robotid as rid
from robotid.cli.app import main
from robotid.report import comparison
from robotid.report.tables import watch as watch_tables


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fitted run in run/ with two new logs, and a fit of the axis with twice the friction in later/."""
    folder = tmp_path_factory.mktemp("monitoring")
    write_accepted_run(folder)
    later = rid.fit(rid.load(folder / "run").fit.model, axis_record("one", 3, TRUTH | {"motor.coulomb.Fc": 0.6}))
    rid.save(later, folder / "later")
    return folder


def log(folder: Path, file: str) -> rid.Dataset:
    return rid.read(folder / f"{file}.csv")


def as_json(document: Any) -> Any:
    return json.loads(json.dumps(document, default=list))


def test_watch_finds_what_the_command_finds(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(folder / f"{name}.csv") for name in ("monday", "friday")]
    assert main(["watch", str(folder / "a.yaml"), *files, "--out", str(folder / "run"), "--json"]) == 5
    printed = json.loads(capsys.readouterr().out)
    found = rid.watch(rid.load(folder / "run"), log(folder, "monday") + log(folder, "friday"))
    assert as_json(watch_tables.document(found)) == printed
    assert found.alarm
    assert [one.state for one in found.logs] == ["unchanged", "changed"]
    assert repr(found).startswith("<WatchedFit: friday: motor.coulomb.Fc has changed by 0.0")
    assert "motor.coulomb.Fc" in found.table()
    frame = found.to_frame()
    assert frame.loc["friday", "parameter"] == "motor.coulomb.Fc"
    assert frame.loc["friday", "change"] == found.logs[1].change.shift


def test_a_model_that_was_saved_alone_needs_its_records(folder: Path, tmp_path: Path) -> None:
    alone = rid.load(rid.save(rid.load(folder / "run").fit, tmp_path / "model.h5"))
    with pytest.raises(rid.RobotidError, match="the records of this fit are not here: one, two"):
        rid.watch(alone, log(folder, "monday"))
    found = rid.watch(alone, log(folder, "monday"), log(folder, "one") + log(folder, "two"))
    assert not found.alarm


def test_compare_finds_what_the_command_finds(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = [str(folder / name) for name in ("run", "later")]
    assert main(["compare", *runs, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    found = rid.compare(runs)
    assert as_json(comparison.document(found)) == printed
    assert [one.parameter for one in found.fits.changed] == ["motor.coulomb.Fc"]
    assert re.match(r"<RunComparison: motor.coulomb.Fc of later \(\+.* %\) differs from run>", repr(found))
    assert found.to_frame().loc[("motor.coulomb.Fc", "later"), "differs"]
    assert len(found.plot().axes) == 3


def test_fits_compare_as_the_runs_that_they_are_saved_in(folder: Path) -> None:
    run, later = rid.load(folder / "run"), rid.load(folder / "later").fit
    found = rid.compare({"run": run.fit, "later": later})
    saved = rid.compare({"run": run, "later": folder / "later"})
    assert found.fits.differences == saved.fits.differences
    assert found.remarks == saved.remarks == ()


def test_fits_of_the_very_records_are_remarked(folder: Path, tmp_path: Path) -> None:
    fit = rid.load(folder / "run").fit
    found = rid.compare({"a": fit, "b": rid.fit(fit.model, fit.dataset, guesses={"motor.coulomb.Fc": 0.2})})
    assert "their errors are not independent" in found.remarks[0]
    shutil.copytree(folder / "run", tmp_path / "copy")
    assert rid.compare([folder / "run", tmp_path / "copy"]).remarks == tuple(
        remark.replace("b was", "copy was").replace("of a:", "of run:") for remark in found.remarks
    )


def test_verdicts_and_gains_stand_beside_the_parameters(folder: Path) -> None:
    fit = rid.load(folder / "run").fit
    found = rid.diagnose(fit, held_out=log(folder, "monday"), criteria=rid.Criteria(max_refits=1))
    better = rid.extend(fit, found, effects=["motor.quadratic_friction"])
    compared = rid.compare({"before": found, "after": better})
    assert compared.runs["before"].verdict == found.verdict
    assert compared.runs["after"].model == (f"{fit.name} extended" if better.added else fit.name)


@pytest.mark.parametrize(
    ("runs", "words"),
    [
        (lambda fit: {"one": fit}, "nothing to compare with"),
        (lambda fit: [fit, fit], "what is compared has no names; give a mapping"),
        (lambda fit: {"one": fit, "two": 3}, "a result of type int cannot be compared"),
        (lambda fit: "runs/one", "nothing to compare with"),
    ],
)
def test_what_cannot_be_compared_is_refused(runs: Any, words: str, folder: Path) -> None:
    with pytest.raises(rid.RobotidError, match=re.escape(words)):
        rid.compare(runs(rid.load(folder / "run").fit))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"level": 1.0}, "the level is 1; give a number between 0 and 1"),
        ({"logs": ()}, "there is no log"),
        ({"logs": "one"}, 'two records have the name "one"'),
        ({"fit": 3}, "there is no fitted model to watch"),
    ],
)
def test_what_cannot_be_watched_is_refused(arguments: dict[str, Any], words: str, folder: Path) -> None:
    given: dict[str, Any] = {"fit": rid.load(folder / "run").fit, "logs": "monday"} | arguments
    logs = log(folder, given["logs"]) if isinstance(given["logs"], str) else given["logs"]
    with pytest.raises(rid.RobotidError, match=re.escape(words)):
        rid.watch(given["fit"], logs, level=given.get("level", 0.01))
