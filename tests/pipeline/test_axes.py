"""The stages of a robot of several axes: one artifact each, and a state for each axis in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from support import fake_stages
from support.fake_stages import CALLS, FAILURES, Sum

from robotid.artifacts.store import load as load_artifact
from robotid.artifacts.store import read_headers
from robotid.config.load import load, load_robot
from robotid.errors import ConfigError, InputError, NumericsError, ThresholdError
from robotid.pipeline import execute as walking
from robotid.pipeline.execute import Outcome, execute, execute_all, status
from robotid.pipeline.run import Run, Runs, runs_of

CONFIG = """
robot:
  name: arm
  axes:
    a1: {model: {motor: [inertia, viscous]}, columns: {tau_m: u, phi_m: x}}
    a2: {model: {motor: [inertia]}, columns: {tau_m: v, phi_m: y}, fit: {max_iterations: 90}}
records:
  - {name: day1, file: day1.csv, columns: {t: t}}
"""
FIRST, BOTH = {"a1": Sum(0.0), "a2": Sum(1.0)}, ("a1", "a2")


pytestmark = pytest.mark.usefixtures("table")


@pytest.fixture
def config(tmp_path: Path) -> Path:
    (tmp_path / "day1.csv").write_text("t,u,x,v,y\n0,1,0,1,0\n1,2,1,2,1\n")
    (tmp_path / "arm.yaml").write_text(CONFIG)
    return tmp_path / "arm.yaml"


def run(config: Path, *overrides: str, axis: str | None = None) -> Runs:
    out = config.parent / "out"
    return runs_of(load_robot(config, overrides), out) if axis is None else Run(load(config, overrides, axis), out)


def made(runs: Runs, **options: Any) -> list[Outcome]:
    return list(execute_all(runs, **options))


def states(runs: Runs) -> dict[str, list[str]]:
    found = status(runs)
    return {axis: [s.state.value for s in found if s.axis == axis] for axis in runs.axes}


def test_every_axis_is_in_the_artifact_of_a_stage(config: Path) -> None:
    outcomes = made(run(config))
    assert [o.content for o in outcomes] == [
        FIRST,
        {"a1": Sum(6.0), "a2": Sum(7.0)},
        {"a1": Sum(6.0), "a2": Sum(8.0)},
    ]
    file = config.parent / "out" / "three.h5"
    assert {axis: load_artifact(file, Sum, axis).content for axis in BOTH} == outcomes[2].content
    assert [header.provenance.command for header in read_headers(file).values()] == [
        "robotid third arm.yaml --axis a1",
        "robotid third arm.yaml --axis a2",
    ]
    assert states(run(config)) == dict.fromkeys(BOTH, ["fresh"] * 3)
    CALLS.clear()
    assert [o.content for o in made(run(config))] == [o.content for o in outcomes]
    assert not CALLS


def test_what_one_axis_depends_on_concerns_no_other(config: Path) -> None:
    made(run(config))
    changed = run(config, "robot.axes.a2.fit.max_iterations=20")
    assert states(changed) == {"a1": ["fresh"] * 3, "a2": ["stale"] * 3}
    CALLS.clear()
    first, *_ = made(changed)
    assert CALLS == {"first": 1, "second": 1, "third": 1}
    assert first.why == "a2: configuration changed: fit"
    assert first.content == {"a1": Sum(0.0), "a2": Sum(0.0)}
    assert states(changed) == dict.fromkeys(BOTH, ["fresh"] * 3)


def test_one_axis_alone_leaves_the_others_as_they_are(config: Path) -> None:
    alone = run(config, axis="a2")
    (content,) = {str(o.content) for o in made(alone) if o.stage == "first"}
    assert content == str({"a2": Sum(1.0)})
    assert states(run(config)) == {"a1": ["absent"] * 3, "a2": ["fresh"] * 3}
    made(run(config, axis="a1"))
    assert states(run(config)) == dict.fromkeys(BOTH, ["fresh"] * 3)
    assert list(read_headers(config.parent / "out" / "one.h5")) == ["a1", "a2"]
    with pytest.raises(InputError, match=r"two.h5, axis a2: is stale .*--axis a2 --set"):
        execute(run(config, "init_rigid.cutoff=3", axis="a2"), "third")


def test_an_axis_that_is_no_longer_there_is_dropped(config: Path) -> None:
    made(run(config))
    config.write_text(CONFIG.replace("    a1:", "    b1:"))
    made(run(config))
    assert list(read_headers(config.parent / "out" / "one.h5")) == ["b1", "a2"]


def test_an_axis_that_fails_does_not_stop_the_others(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def first(settings: Any) -> Sum:
        if settings.robot.name == "arm_a1":
            raise NumericsError("it is singular", where="day1")
        return Sum(1.0)

    monkeypatch.setattr(fake_stages, "first", first)
    outcomes = made(run(config))
    assert [list(o.contents) for o in outcomes] == [["a2"]] * 3
    assert list(outcomes[0].failures) == ["a1"]
    assert states(run(config)) == {"a1": ["absent"] * 3, "a2": ["fresh"] * 3}


def test_all_axes_that_fail_are_one_error(config: Path) -> None:
    FAILURES["first"] = NumericsError("it is singular", where="day1")
    with pytest.raises(NumericsError, match=r"axis a1: day1: it is singular; axis a2: day1: it is singular"):
        made(run(config))
    with pytest.raises(NumericsError, match=r"^axis a2: day1: it is singular"):
        made(run(config, axis="a2"))


def test_an_axis_below_its_threshold_is_saved_and_goes_no_further(config: Path) -> None:
    overrides = ["robot.axes.a2.validate.perturbation=13"]
    for _ in "made", "fresh":
        outcome = made(run(config, *overrides))[-1]
        assert outcome.content == {"a1": Sum(6.0), "a2": Sum(8.0, failed=("the fit is 1 %, below 2 %",))}
        assert isinstance(outcome.failures["a2"], ThresholdError)
        assert list(outcome.failures) == ["a2"]


def test_artifacts_of_a_single_joint_are_of_no_use_to_several_axes(config: Path) -> None:
    made(run(config))
    joint = config.parent / "joint.yaml"
    joint.write_text("robot: {name: j, model: {motor: [inertia]}}\nrecords: [{name: day1, file: day1.csv}]\n")
    alone = Run(load(joint), config.parent / "out")
    assert {s.why for s in status(alone)[:1]} == {"made for several axes: a1, a2"}
    assert len(made(alone)) == 3
    assert {s.why for s in status(run(config))[:2]} == {"made for a single joint"}
    with pytest.raises(ConfigError, match='it holds no axis "a1"; it is of a single joint'):
        load_artifact(config.parent / "out" / "one.h5", Sum, "a1")


def test_a_file_is_read_once_for_all_axes(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Path] = []
    reader = walking.find("robotid.signals.readers:read")
    monkeypatch.setattr("robotid.signals.readers.read", lambda path: asked.append(path) or reader(path))
    made(run(config))
    assert len(asked) == 1
