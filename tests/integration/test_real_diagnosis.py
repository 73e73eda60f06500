"""Diagnosis of a real machine: what the symmetric model of EMPS lacks, and whether that carries over."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest
from support.paths import ROOT

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.diagnosis.results import Diagnosis
from robotid.extension.results import Extension

EMPS = ROOT.parent / "shared" / "data" / "emps"


@cache
def out() -> Path:
    """Run directory of the symmetric model on the training record."""
    if not EMPS.is_dir():
        pytest.skip("the measured records emps are third-party data and not here")
    folder = Path(mkdtemp())
    assert main(["run", str(ROOT / "configs" / "emps.yaml"), "--out", str(folder), "--quiet"]) == 0
    return folder


def diagnosis() -> Diagnosis:
    found = load(out() / "diagnosis.h5", Diagnosis).content
    assert isinstance(found, Diagnosis)
    return found


def extension() -> Extension:
    found = load(out() / "extension.h5", Extension).content
    assert isinstance(found, Extension)
    return found


def test_friction_by_direction_is_named() -> None:
    first = diagnosis().causes[0]
    assert diagnosis().verdict == "named"
    assert "motor.asymmetric_viscous" in first.twins


def test_its_size_is_the_published_one() -> None:
    """Half the difference of the published 166.7 and 240.4 N s/m."""
    found = {p.name: p.value for p in extension().fit.parameters}
    assert found["motor.asymmetric_viscous.dFv"] == pytest.approx((166.7 - 240.4) / 2, rel=0.05)


def test_what_differs_between_the_recordings_is_named() -> None:
    changes = [c.effect for c in diagnosis().causes if c.effect.startswith("record_change.pulses.")]
    assert changes
    assert all("motor.viscous" in effect or "motor.coulomb" in effect for effect in changes)


def test_it_carries_over_to_the_pulses_record() -> None:
    assert extension().added == ("motor.asymmetric_viscous",)
    assert not extension().after["pulses"].used
    assert extension().after["pulses"].rmse < extension().before["pulses"].rmse


def test_the_gain_that_is_told_is_that_of_the_records(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["extend", str(ROOT / "configs" / "emps.yaml"), "--out", str(out()), "--json", "--quiet"]) == 0
    told: dict[str, Any] = json.loads(capsys.readouterr().out)
    before, after = told["before"]["fit_percent"], told["after"]["fit_percent"]
    for name in ("train", "pulses"):
        assert after[name] == pytest.approx(extension().after[name].fit_percent, abs=0.01)
        assert before[name] == pytest.approx(extension().before[name].fit_percent, abs=0.01)
    assert after["pulses"] > before["pulses"]
