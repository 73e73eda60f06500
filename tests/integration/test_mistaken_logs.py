"""Mistakes that were accepted: the pipeline ends with a verdict or one clear line, never with a singular matrix."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.mistaken_logs import MISTAKES, configuration, right_log, write_csv

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.diagnosis.results import Diagnosis
from robotid.signals.plausibility import CHECKS

BY_NAME = {mistake.name: mistake for mistake in MISTAKES}
SAMPLES = 1000


@pytest.mark.parametrize("name", ["torque_sign", "speed_zeros", "speed_unrelated", "torque_is_angle"])
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
