"""The stage diagnose: which model and which records it looks at, and how they are simulated."""

from __future__ import annotations

import shutil
from functools import cache
from typing import Any
from zlib import crc32

import numpy as np
import pytest
from support.diagnosed_run import ran

from robotid.artifacts.store import load as load_artifact
from robotid.config.load import load
from robotid.diagnosis.results import Diagnosis
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.estimate.result import Fits
from robotid.pipeline.execute import execute
from robotid.pipeline.run import Run
from robotid.pipeline.table import STAGES
from robotid.progress import Progress
from robotid.signals.quality import Recordings
from robotid.stages.diagnose import diagnose


@cache
def fitted(case: str, *changes: str) -> tuple[Run, Recordings, Fits]:
    """A case fitted anew with changes of the configuration, in a directory of its own."""
    config, out = ran(case)
    run = Run(load(config, changes), out.parent / f"out{crc32(repr(changes).encode())}")
    shutil.copytree(out, run.out)
    execute(run, "fit")
    recordings, fits = (load_artifact(run.file(STAGES[s]), STAGES[s].type()).content for s in ("collect", "fit"))
    return run, recordings, fits


def diagnosed(case: str, *changes: str, said: list[Any] | None = None) -> Diagnosis:
    run, recordings, fits = fitted(case, *changes)
    return diagnose(run.loaded.config, recordings, fits, None if said is None else said.append)


def stored(case: str) -> Diagnosis:
    found = load_artifact(ran(case)[1] / "diagnosis.h5", Diagnosis).content
    assert isinstance(found, Diagnosis)
    return found


def test_which_model_is_diagnosed_may_be_told() -> None:
    changes = ("fit.models={one: [slow], both: [slow, wide]}", "fit.best=both", "diagnose.model=one")
    d = diagnosed("clean", *changes)
    assert (d.model, d.verdict) == ("one", "clean")


def test_what_goes_on_is_told() -> None:
    said: list[Any] = []
    diagnosed("clean", said=said)
    assert all(isinstance(one, Progress) for one in said)
    assert any("catalogue" in one.label for one in said)


def test_a_round_counts_its_candidates() -> None:
    said: list[Any] = []
    diagnosed("named", said=said)
    counted = [one for one in said if one.total]
    assert counted
    assert all(one.label.startswith("round ") and f"{one.done + 1} of {one.total}" in one.label for one in counted)


@pytest.mark.parametrize("case", ["named", "clean"])
def test_every_record_is_measured_by_the_model_as_it_is(case: str) -> None:
    _, recordings, fits = fitted(case)
    model, d = fitted_model(fits.models[fits.best]), stored(case)
    assert set(d.records) == {r.name for r in recordings.records}
    for record in recordings.records:
        error = record.dphi_m - simulate_record(model, record).signal("speed")
        found = d.records[record.name]
        assert found.rmse == pytest.approx(float(np.sqrt(np.mean(error**2))), rel=1e-3)
        assert found.misfit**2 + found.noise_floor**2 == pytest.approx(found.rmse**2, rel=1e-6)
        assert found.role == record.role
        assert 0.0 <= found.explained_after <= 1.0


def test_the_missing_torque_is_that_of_the_hidden_effect() -> None:
    """Over the motion of the slow record, but for what the fit has taken of it by more viscous and dry friction."""
    d = stored("named")
    speed = {curve.along: curve for curve in d.curves}["dphi_m"]
    assert d.curves[0].along == "dphi_m"
    moving = np.abs(speed.x) > 0.05
    v, torque = speed.x[moving], speed.missing_torque[moving]
    hidden = -0.15 * np.exp(-(v**2)) * np.sign(v)
    taken = np.column_stack([np.sign(v), v])
    weight = np.sqrt(speed.count[moving])[:, None]
    left = [s - taken @ np.linalg.lstsq(weight * taken, weight[:, 0] * s, rcond=None)[0] for s in (torque, hidden)]
    assert np.corrcoef(*left)[0, 1] > 0.95


@pytest.mark.parametrize("change", ["fit.horizon=1.0", "fit.initial_states=fixed", "fit.output=position"])
def test_a_clean_model_is_clean_however_it_is_simulated(change: str) -> None:
    d = diagnosed("clean", change)
    assert (d.verdict, d.causes, d.shape) == ("clean", (), None)


def test_a_cause_is_found_in_the_position_as_well() -> None:
    d = diagnosed("named", "fit.output=position", "diagnose.max_causes=1")
    assert [c.effect for c in d.causes][:1] == ["motor.stribeck"]
    (dFs,) = [p for p in d.causes[0].parameters if p.name.endswith("dFs")]
    assert dFs.value == pytest.approx(0.15, rel=0.15)
    assert d.unit == "rad"


def test_long_records_are_looked_at_in_stretches_and_it_is_said() -> None:
    d = diagnosed("named", "diagnose.samples=2000", "diagnose.max_causes=1", "diagnose.max_refits=1")
    assert any("2000 of" in remark and "diagnose.samples" in remark for remark in d.remarks)
    assert d.causes[0].effect == "motor.stribeck"
    assert all(len(trace.t) <= 2000 for trace in d.residuals.values())
