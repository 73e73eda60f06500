"""extended.yaml is a complete configuration: it loads, and a fit from it is the extended model again."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from support.diagnosed_run import ran

from robotid.artifacts.store import load as load_artifact
from robotid.config.extended import extended_configuration
from robotid.config.load import load, parse
from robotid.diagnosis.results import Diagnosis
from robotid.estimate.result import FitResult, Fits
from robotid.extension.results import Extension
from robotid.model.structure import change
from robotid.pipeline.execute import execute
from robotid.pipeline.run import Run
from robotid.pipeline.table import STAGES
from robotid.signals.quality import Recordings
from robotid.stages.extend import extend

TO_FIT = ("excite", "collect", "init-rigid", "init-flex", "fit")


def content(folder: Path, stage: str) -> object:
    """What a stage left in a run directory."""
    return load_artifact(folder / STAGES[stage].output, STAGES[stage].type()).content


def extension(case: str) -> Extension:
    found = content(ran(case)[1], "extend")
    assert isinstance(found, Extension)
    return found


def inputs(case: str) -> tuple[Recordings, Fits, Diagnosis]:
    """What the stage extend is given."""
    recordings, fits, diagnosis = (content(ran(case)[1], stage) for stage in ("collect", "fit", "diagnose"))
    assert isinstance(recordings, Recordings)
    assert isinstance(fits, Fits)
    assert isinstance(diagnosis, Diagnosis)
    return recordings, fits, diagnosis


@cache
def again() -> FitResult:
    """The fit of a run that starts from extended.yaml, in a directory of its own."""
    folder = ran("named")[1]
    run = Run(load(folder / "extended.yaml"), folder.parent / "again")
    for stage in TO_FIT:
        execute(run, stage)
    fits = content(run.out, "fit")
    assert isinstance(fits, Fits)
    return fits.models[fits.best]


def test_it_loads_and_has_the_extended_structure() -> None:
    config = load(ran("named")[1] / "extended.yaml").config
    assert config.structure() == extension("named").fit.structure
    assert set(config.structure().effects) == {"motor.inertia", "motor.viscous", "motor.coulomb", "motor.stribeck"}
    assert config.plant == load(ran("named")[0]).config.plant
    assert config.records == load(ran("named")[0]).config.records


def test_a_fit_from_it_is_the_extended_model_again() -> None:
    e = extension("named")
    first, second = ({p.name: p for p in fit.parameters} for fit in (e.fit, again()))
    assert list(first) == list(second)
    for name, p in first.items():
        assert abs(second[name].value - p.value) < 0.1 * p.std
    assert again().fit_percent == pytest.approx({n: s.fit_percent for n, s in e.after.items() if s.used}, abs=0.01)


def test_the_extended_model_lacks_nothing() -> None:
    folder = ran("named")[1].parent / "again"
    again()
    found = execute(Run(load(ran("named")[1] / "extended.yaml"), folder), "diagnose").content
    assert (found.verdict, found.causes) == ("clean", ())


def test_it_follows_the_parts_of_the_configuration_that_no_fit_depends_on(tmp_path: Path) -> None:
    config, out = ran("named")
    copy = Path(shutil.copytree(out, tmp_path / "copy"))
    outcome = execute(Run(load(config, ["report.title=another"]), copy), "extend")
    assert not outcome.ran
    assert load(copy / "extended.yaml").config.report.title == "another"


def test_a_clean_model_is_left_as_it_was() -> None:
    e = extension("clean")
    assert (e.added, e.model_after, e.dropped) == ((), e.model_before, ())
    config = load(ran("clean")[1] / "extended.yaml").config
    assert config.structure() == load(ran("clean")[0]).config.structure()


def test_files_are_found_from_where_it_is_kept(tmp_path: Path) -> None:
    (tmp_path / "configs").mkdir()
    text = ran("named")[0].read_text(encoding="utf-8").split("plant:")[0].split("records:")[0]
    text += "records:\n  - {name: slow, file: data/slow.csv}\n  - {name: wide, file: ../other/wide.csv}\n"
    (tmp_path / "configs" / "a.yaml").write_text(text, encoding="utf-8")
    loaded, kept = load(tmp_path / "configs" / "a.yaml"), tmp_path / "runs" / "deep"
    kept.mkdir(parents=True)
    (kept / "extended.yaml").write_text(extended_configuration(loaded, extension("named"), kept), encoding="utf-8")
    moved = load(kept / "extended.yaml")
    for name, place in (("slow", "configs/data/slow.csv"), ("wide", "other/wide.csv")):
        file = next(r.file for r in moved.config.records if r.name == name)
        assert file is not None
        assert (moved.directory / file).resolve() == (tmp_path / place).resolve()
    late = replace(extension("named"), late=0.0015)
    text = extended_configuration(load(tmp_path / "configs" / "a.yaml", ["records.1.torque_delay=0.002"]), late, kept)
    assert {r.name: r.torque_delay for r in parse(text).records} == pytest.approx({"slow": 0.0015, "wide": 0.0035})


def test_effects_may_be_asked_for_instead_of_the_causes() -> None:
    config = load(ran("named")[0], ["extend.effects=[motor.quadratic_friction]", "fit.max_iterations=20"]).config
    e = extend(config, *inputs("named"))
    tried = {*e.added, *(one.effect for one in e.dropped)}
    assert tried == {"motor.quadratic_friction"}
    assert e.before["check"].fit_percent == pytest.approx(extension("named").before["check"].fit_percent)


def test_a_difference_is_kept_as_a_change_of_its_record() -> None:
    effect = change("slow", "motor.coulomb.Fc")
    config = load(ran("clean")[0], [f"extend.effects=[{effect}]"])
    recordings, fits, diagnosis = inputs("clean")
    held_in = Recordings(tuple(r for r in recordings.records if r.role == "estimate"), ())
    e = extend(config.config, held_in, fits, diagnosis)  # without a record held out, nothing is dropped
    assert e.added == (effect,)
    text = extended_configuration(config, e, ran("clean")[1])
    again_ = parse(text)
    assert again_.robot.changes == {"slow": ("motor.coulomb.Fc",)}
    assert again_.structure() == e.fit.structure
    found = {p.name: p.value for p in e.fit.parameters}
    assert again_.robot.parameters[effect].guess == pytest.approx(found[effect], abs=1e-12)
    assert abs(found[effect]) < 0.01
