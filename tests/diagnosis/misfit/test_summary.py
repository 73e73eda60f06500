"""Where a misfit sits: which noise it is set against, and its torque smoothed by."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.judged_records import clean_records, model
from support.small_bench import records, simulated

from robotid.diagnosis.misfit import summary as where
from robotid.diagnosis.misfit.missing_torque import MissingTorque
from robotid.diagnosis.noise.noise_floor import noise_levels
from robotid.estimate.fitted_model import SimulatedSegment, simulate_record


@pytest.mark.parametrize("known", [False, True], ids=["alone", "with the causes"])
def test_a_misfit_is_set_against_and_smoothed_by_the_noise_behind_the_best_model_of_its_record(
    known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = [
        c
        for run in simulated(records({"motor.stribeck.dFs": 0.15, "motor.stribeck.vs": 1.0}))
        for c in run.segments("speed")
    ]
    clean = [c for run in simulated(records({})) for c in run.segments("speed")]
    after = [SimulatedSegment(b.record, c.trajectory, c.residual) for b, c in zip(before, clean, strict=True)]
    used, smooth = list[tuple[str, float, float]](), where.missing_torque

    def watched(segment: SimulatedSegment, output: Any, noise: float, torque: float) -> MissingTorque:
        used.append((segment.record.name, noise, torque))
        return smooth(segment, output, noise, torque)

    monkeypatch.setattr(where, "missing_torque", watched)
    found = where.locate_misfit(before, after if known else (), "speed")
    best = noise_levels(after if known else before, "speed")
    expected = [(one.record.name, noise.output, noise.torque) for one, noise in zip(before, best, strict=True)]
    assert used == (expected * 2 if known else expected)
    assert found.floors == pytest.approx(
        {one.record.name: noise.floor for one, noise in zip(before, best, strict=True)}
    )
    assert list(found.missing) == [one.record.name for one in before]
    assert found.twist == {}  # a rigid axis


def test_the_twist_of_a_gear_is_kept_at_the_times_of_the_missing_torque() -> None:
    runs = [simulate_record(model({"gear.spring.k1": 1.2e6}), record) for record in clean_records()]
    found = where.locate_misfit([segment for run in runs for segment in run.segments("speed")], (), "speed")
    for run in runs:
        simulated_twist, kept = run.trajectories[0].twist, found.twist[run.record.name]
        assert simulated_twist is not None
        assert len(kept) == len(found.missing[run.record.name].t)
        assert np.std(kept) == pytest.approx(np.std(simulated_twist), rel=0.5)
