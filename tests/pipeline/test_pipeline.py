"""The pipeline makes what is not fresh, says why, and leaves whole whatever was there before."""

from __future__ import annotations

import shutil
from dataclasses import make_dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from support.fake_stages import CALLS, FAILURES, Sum

from robotid.artifacts.store import load as load_artifact
from robotid.artifacts.store import read_header, save
from robotid.config.load import load
from robotid.errors import InputError, NumericsError, ThresholdError
from robotid.pipeline import execute as walking
from robotid.pipeline import freshness
from robotid.pipeline.execute import Outcome, execute, execute_all, status
from robotid.pipeline.freshness import StageStatus
from robotid.pipeline.run import Run
from robotid.progress import Begun, Progress

CONFIG = """
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - {name: day1, file: data/day1.csv}
  - {name: day2, file: more/day1.csv, role: validate}
"""
NAMES = ["first", "second", "third"]


pytestmark = pytest.mark.usefixtures("table")


@pytest.fixture
def config(tmp_path: Path) -> Path:
    for folder in ("data", "more"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "day1.csv").write_text("t,u\n0,1\n1,2\n")
    (tmp_path / "axis.yaml").write_text(CONFIG)
    return tmp_path / "axis.yaml"


def run(config: Path, *overrides: str) -> Run:
    return Run(load(config, overrides), config.parent / "out")


def made(config: Path, *overrides: str, **options: Any) -> list[Outcome]:
    return list(execute_all(run(config, *overrides), **options))


def other_value(file: Path) -> None:
    """Damage that only the checksum shows."""
    with h5py.File(file, "r+") as artifact:
        artifact["content/value"][()] += 1


def ran(outcomes: list[Outcome]) -> list[str]:
    return [outcome.stage for outcome in outcomes if outcome.ran]


def states(config: Path, *overrides: str) -> list[tuple[str, str]]:
    found: tuple[StageStatus, ...] = status(run(config, *overrides))
    assert [s.stage for s in found] == NAMES
    return [(s.state.value, s.why) for s in found]


def test_everything_is_made_once(config: Path) -> None:
    assert states(config) == [("absent", "not made yet")] * 3
    assert ran(made(config)) == NAMES
    assert states(config) == [("fresh", "")] * 3
    again = made(config)
    assert ran(again) == []
    assert [o.content for o in again] == [Sum(0.0), Sum(6.0), Sum(6.0)]
    assert [CALLS[name] for name in NAMES] == [1, 1, 1]


def test_a_section_that_counts(config: Path) -> None:
    made(config)
    stale = ("stale", "configuration changed: init_rigid")
    assert states(config, "init_rigid.order=3") == [("fresh", ""), stale, ("stale", "two.h5 is stale")]
    assert states(config, "init_flex.window=3") == [("fresh", "")] * 3


def test_words_that_mean_the_same(config: Path) -> None:
    made(config)
    config.write_text("# a comment\n" + CONFIG + "fit: {max_iterations: 50}\n")
    assert states(config) == [("fresh", "")] * 3


def test_an_input_made_anew_with_the_same_content_changes_nothing(config: Path) -> None:
    made(config)
    assert ran(made(config, "fit.max_iterations=40")) == ["first"]
    assert ran(made(config, "fit.max_iterations=60")) == NAMES


def test_an_input_made_anew_with_other_content(config: Path) -> None:
    made(config)
    execute(run(config, "fit.max_iterations=60"), "first")
    found = states(config, "fit.max_iterations=60")
    assert found == [("fresh", ""), ("stale", "one.h5 changed"), ("stale", "two.h5 is stale")]


@pytest.mark.parametrize("folder", ["data", "more"])
def test_a_measured_file_that_changed(folder: str, config: Path) -> None:
    made(config)
    (config.parent / folder / "day1.csv").write_text("t,u\n0,1\n1,3\n")
    assert states(config)[1] == ("stale", f"file {folder}/day1.csv changed")


def test_a_measured_file_that_is_gone(config: Path) -> None:
    made(config)
    gone = config.parent / "data" / "day1.csv"
    gone.unlink()
    assert states(config)[1] == ("stale", f"{gone} cannot be read: No such file or directory")
    with pytest.raises(InputError, match="there is no such file; a record's file is relative to the configuration"):
        made(config)


def test_a_file_of_two_records_is_read_once(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config.write_text(CONFIG.replace("more/", "data/"))
    asked: list[Path] = []
    reader = walking.find("robotid.signals.readers:read")
    monkeypatch.setattr("robotid.signals.readers.read", lambda path: asked.append(path) or reader(path))
    assert made(config)[1].content == Sum(6.0)
    assert asked == [config.parent / "data/day1.csv"]


def test_another_version(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made(config)
    monkeypatch.setattr(freshness, "__version__", "9.9")
    assert states(config)[0][1].startswith("made by version 0.")


def test_times_do_not_count(config: Path) -> None:
    made(config)
    shutil.copytree(config.parent / "out", config.parent / "copy", copy_function=shutil.copyfile)
    (config.parent / "copy" / "one.h5").touch()
    assert [s.state.value for s in status(Run(load(config), config.parent / "copy"))] == ["fresh"] * 3


@pytest.mark.parametrize(
    ("damage", "why"),
    [
        (lambda file: file.write_bytes(b"not this"), "this is not a readable HDF5 file: foreign or damaged"),
        (lambda file: file.write_bytes(file.read_bytes()[:-400]), "damaged: the file does not match its checksum"),
        (lambda file: shutil.copy(file.with_name("one.h5"), file), "it holds what first makes"),
        (lambda file: other_value(file), "damaged: the file does not match its checksum"),
    ],
)
def test_a_damaged_artifact_is_made_again(damage: Any, why: str, config: Path) -> None:
    made(config)
    damage(config.parent / "out" / "two.h5")
    assert states(config) == [("fresh", ""), ("stale", why), ("stale", "two.h5 is stale")]
    assert ran(made(config)) == ["second"], "the third is fresh once its input is what it was"


def test_an_artifact_of_another_layout_is_made_again(config: Path) -> None:
    made(config)
    file = config.parent / "out" / "two.h5"
    other = make_dataclass("Sum", [("total", float)], frozen=True)
    save(file, other(1.0), read_header(file).provenance)
    (outcome,) = [o for o in made(config) if o.ran]
    assert (outcome.stage, outcome.why) == ("second", "of another version")


def test_one_stage_reads_no_damaged_input_and_makes_its_own_again(config: Path) -> None:
    made(config)
    other_value(config.parent / "out" / "two.h5")
    with pytest.raises(
        InputError, match=r"two\.h5: is stale \(damaged: the file does not match its checksum\); run `robotid second"
    ):
        execute(run(config), "third", force=True)
    assert execute(run(config), "second").why == "damaged: the file does not match its checksum"


def test_one_stage_needs_its_inputs(config: Path) -> None:
    out = config.parent / "out"
    with pytest.raises(InputError) as caught:
        execute(run(config), "second")
    assert str(caught.value) == (
        f"{out}/one.h5: is missing; run `robotid first {config} --out {out}` first, "
        f"or `robotid run {config} --out {out}` for all"
    )
    assert CALLS == {}


def test_the_command_that_resumes_repeats_the_options(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(config.parent)
    path = Path("axis.yaml")
    list(execute_all(Run(load(path), Path("runs/axis"))))
    with pytest.raises(InputError) as caught:
        execute(Run(load(path, ["init_rigid.order=3"]), Path("runs/axis")), "third")
    assert str(caught.value) == (
        "runs/axis/two.h5: is stale (configuration changed: init_rigid); "
        "run `robotid second axis.yaml --set init_rigid.order=3` first, "
        "or `robotid run axis.yaml --set init_rigid.order=3` for all"
    )


def test_force(config: Path) -> None:
    made(config)
    outcome = execute(run(config), "second", force=True)
    assert (outcome.ran, outcome.why) == (True, "forced")
    assert CALLS["second"] == 2
    assert states(config) == [("fresh", "")] * 3


def test_a_dry_run_only_tells(config: Path) -> None:
    assert [o.why for o in made(config, dry_run=True)] == ["not made yet", *["an earlier stage would run"] * 2]
    assert not (config.parent / "out").exists()
    made(config)
    assert [o.why for o in made(config, dry_run=True)] == ["fresh"] * 3
    planned = made(config, "init_rigid.order=3", dry_run=True)
    assert [o.why for o in planned] == ["fresh", "configuration changed: init_rigid", "an earlier stage would run"]
    assert [CALLS[name] for name in NAMES] == [1, 1, 1]


def test_a_stage_that_fails_leaves_what_was_there(config: Path) -> None:
    made(config)
    before = {file: file.read_bytes() for file in (config.parent / "out").iterdir()}
    FAILURES["second"] = NumericsError("nothing moves")
    with pytest.raises(NumericsError):
        made(config, "init_rigid.order=3")
    assert {file: file.read_bytes() for file in (config.parent / "out").iterdir()} == before


@pytest.mark.parametrize("error", [np.linalg.LinAlgError("Singular matrix"), ZeroDivisionError(), OverflowError()])
def test_arithmetic_that_breaks_down_is_no_bug(config: Path, error: Exception) -> None:
    FAILURES["second"] = error
    with pytest.raises(NumericsError, match="the arithmetic breaks down") as raised:
        made(config)
    assert raised.value.where == "second"
    assert "robotid check" in raised.value.hint


def test_another_error_of_a_stage_stays_a_bug(config: Path) -> None:
    FAILURES["second"] = ValueError("an operand of another shape")
    with pytest.raises(ValueError, match="another shape"):
        made(config)


def test_the_keyboard_between_two_stages(config: Path) -> None:
    FAILURES["second"] = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        made(config)
    FAILURES.clear()
    assert ran(made(config)) == ["second", "third"]


def test_an_interrupted_stage_is_saved_but_not_done(config: Path) -> None:
    outcomes = made(config, "validate.perturbation=12")
    assert [o.interrupted for o in outcomes] == [False, False, True]
    file = outcomes[-1].file
    assert load_artifact(file, Sum).content.interrupted
    assert states(config, "validate.perturbation=12")[2] == ("stale", "its run was interrupted")
    assert file.stat().st_mtime < outcomes[0].file.stat().st_mtime, "make, too, takes it for stale"


def test_what_is_worse_than_demanded_is_saved_and_said_every_time(config: Path) -> None:
    for _ in range(2):
        with pytest.raises(ThresholdError) as caught:
            made(config, "validate.perturbation=13")
        file = config.parent / "out" / "three.h5"
        assert str(caught.value) == f"{file}: the fit is 1 %, below 2 %; see `robotid show` of it"
        assert load_artifact(file, Sum).content.value == 6.0
        assert file.stat().st_mtime < file.with_name("two.h5").stat().st_mtime
    assert CALLS["third"] == 1


def test_what_is_found_fresh_is_new_to_make(config: Path) -> None:
    first, second, _ = made(config)
    first.file.touch()
    assert second.file.stat().st_mtime_ns < first.file.stat().st_mtime_ns
    execute(run(config), "second")
    assert second.file.stat().st_mtime_ns >= first.file.stat().st_mtime_ns


def test_a_log_hears_of_stages_and_what_they_tell(config: Path) -> None:
    heard: list[Any] = []
    made(config, log=heard.append)
    assert heard == [Begun("first"), Begun("second"), Begun("third"), Progress("third", 1, 2)]


def test_provenance_is_enough_to_make_it_again(config: Path) -> None:
    outcome = made(config, "init_rigid.order=3")[1]
    header = read_header(outcome.file)
    assert header.provenance.command == "robotid second axis.yaml --set init_rigid.order=3"
    assert header.provenance.inputs.keys() == {"first", "file data/day1.csv", "file more/day1.csv"}
    assert header.provenance.inputs["first"] == read_header(outcome.file.with_name("one.h5")).digest
    resolved = config.with_name("resolved.yaml")
    resolved.write_text(header.provenance.configuration)
    assert load(resolved).config == load(config, ["init_rigid.order=3"]).config
