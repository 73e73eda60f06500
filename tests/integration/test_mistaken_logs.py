"""Every mistake to the end: a run stops with one line.

Where it was accepted, the pipeline ends with a verdict or one clear line, never with a singular matrix.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.mistaken_logs import MISTAKES, Log, Mistake, configuration, right_log, without_speed, write_csv

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.diagnosis.results import Diagnosis
from robotid.signals.plausibility import CHECKS

BY_NAME = {mistake.name: mistake for mistake in MISTAKES}
SAMPLES = 1000


FATAL = [(k, s, m) for m in MISTAKES if m.severity == "fatal" for k in m.kinds for s in m.speeds]


def run(folder: Path, kind: str, log: Log) -> int:
    write_csv(folder / "log.csv", log)
    (folder / "axis.yaml").write_text(configuration(kind, {"estimate": "log.csv"}))
    return main(["run", str(folder / "axis.yaml"), "--out", str(folder / "out"), "--quiet"])


@pytest.mark.parametrize(
    ("kind", "speed", "mistake"), FATAL, ids=[f"{m.name}-{k}-{'speed' if s else 'angle'}" for k, s, m in FATAL]
)
def test_a_run_stops_with_number_consequence_and_cure(
    kind: str, speed: bool, mistake: Mistake, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = mistake.make(right_log(kind) if speed else without_speed(right_log(kind)))
    assert run(tmp_path, kind, log) == 4
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("estimate: ")
    assert ", so that " in line
    assert f"--accept {mistake.found} accepts it" in line
    assert not (tmp_path / "out" / "rigid.h5").exists()


def _with(name: str, at: int | slice, value: float) -> Callable[[Log], Log]:
    def make(log: Log) -> Log:
        values = log[name].copy()
        values[at] = value
        return log | {name: values}

    return make


def _first(samples: int) -> Callable[[Log], Log]:
    return lambda log: {name: values[:samples] for name, values in log.items()}


UNREADABLE: dict[str, tuple[Callable[[Log], Log], int, str]] = {
    "constant torque": (_with("tau_m", slice(None), 1.0), 4, "the torque never changes"),
    "constant angle": (_with("phi_m", slice(None), 1.0), 4, "the motor never moves"),
    "constant time": (_with("t", slice(None), 1.0), 3, "time is written with too few digits"),
    "no torque at all": (_with("tau_m", slice(None), np.nan), 3, "tau_m is not a number in 3000 of 3000 samples"),
    "half a torque": (_with("tau_m", slice(None, None, 2), np.inf), 3, "tau_m is not a number in 1500 samples"),
    "one sample": (_first(1), 3, "there is a single sample"),
    "two samples": (_first(2), 3, "a record of 2 samples is too short"),
    "an absurd torque": (lambda log: log | {"tau_m": 1e200 * log["tau_m"]}, 4, "which no sensor of a machine does"),
    "an absurd angle": (lambda log: log | {"phi_m": 1e-200 * log["phi_m"]}, 4, "which no sensor of a machine does"),
}


@pytest.mark.parametrize("speed", [True, False], ids=["speed", "angle"])
@pytest.mark.parametrize("name", UNREADABLE)
def test_a_log_that_holds_nothing_is_one_line(
    name: str, speed: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, code, what = UNREADABLE[name]
    log = make(right_log("rigid"))
    assert run(tmp_path, "rigid", log if speed else without_speed(log)) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert what in line
    assert "; " in line


@pytest.mark.parametrize(("start", "step", "found"), [(0, 1, ["repetition"]), (400, 1, ["repetition"]), (0, 3, [])])
def test_a_validation_record_that_overlaps_or_is_sampled_otherwise(
    start: int, step: int, found: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = right_log("rigid")
    write_csv(tmp_path / "log.csv", log)
    write_csv(tmp_path / "other.csv", {name: values[start::step] for name, values in log.items()})
    (tmp_path / "axis.yaml").write_text(configuration("rigid", {"estimate": "log.csv", "validate": "other.csv"}))
    assert main(["check", str(tmp_path / "axis.yaml"), "--out", str(tmp_path / "out"), "--json"]) == 0
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert [f["check"] for f in findings if f["record"] == "validate"] == found


RIGID = ["torque_sign", pytest.param("speed_zeros", marks=pytest.mark.slow), "speed_unrelated", "torque_is_angle"]


@pytest.mark.parametrize("name", RIGID)
def test_a_rigid_axis(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = {signal: values[:SAMPLES] for signal, values in BY_NAME[name].make(right_log("rigid")).items()}
    write_csv(tmp_path / "log.csv", log)
    config = tmp_path / "axis.yaml"
    config.write_text(configuration("rigid", {"estimate": "log.csv"}, accept=tuple(CHECKS)))
    out = tmp_path / "out"
    code = main(["run", str(config), "--out", str(out), "--quiet"])
    shown = capsys.readouterr().err
    last = shown.splitlines()[-1:]
    assert code in (0, 4), shown
    if code == 0:
        found = load(out / "diagnosis.h5", Diagnosis).content
        assert found.verdict == "not explained"
        assert not any(np.isfinite(m.noise_floor) for m in found.records.values())
    else:
        assert "; " in last[0]  # what is wrong, and what to do


def test_a_flexible_joint_whose_speed_is_zero(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_csv(tmp_path / "log.csv", BY_NAME["speed_zeros"].make(right_log("flexible")))
    config = tmp_path / "joint.yaml"
    config.write_text(configuration("flexible", {"estimate": "log.csv"}, accept=tuple(CHECKS)))
    assert main(["run", str(config), "--out", str(tmp_path / "out"), "--quiet"]) == 4
    assert "write dphi_m: null" in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.slow
@pytest.mark.parametrize("speed", [True, False], ids=["speed", "angle"])
@pytest.mark.parametrize("name", ["torque_sign", "angle_sign"])
def test_a_flexible_joint_with_a_wrong_sign_is_given_no_cause(
    name: str, speed: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No inertia but next to nothing moves that way."""
    log = BY_NAME[name].make(right_log("flexible") if speed else without_speed(right_log("flexible")))
    write_csv(tmp_path / "log.csv", {signal: values[: 2 * SAMPLES] for signal, values in log.items()})
    config = tmp_path / "joint.yaml"
    config.write_text(configuration("flexible", {"estimate": "log.csv"}, accept=tuple(CHECKS)))
    code = main(["run", str(config), "--out", str(tmp_path / "out"), "--quiet"])
    shown = capsys.readouterr().err
    assert code in (0, 4), shown
    if code == 0:
        found = load(tmp_path / "out" / "diagnosis.h5", Diagnosis).content
        assert found.verdict in ("not explained", "unknown")
        assert not found.causes
    else:
        assert "; " in shown.splitlines()[-1]
