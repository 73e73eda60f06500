"""Numbers of periods a turn are read off the misfit, between the points of any grid."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_bench import begun, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.scoring.periods import Wave, period_peaks
from robotid.diagnosis.scoring.ranking import misfit_gradients, refine
from robotid.diagnosis.search.refits import refit_hopeful


@pytest.mark.parametrize(
    ("effect", "n"), [("motor.cogging", 7.3), ("motor.position_friction", 2.6), ("motor.position_friction", 5.15)]
)
def test_the_number_of_periods_is_found_between_the_points_of_the_grid(effect: str, n: float) -> None:
    state = begun(records({f"{effect}.A": 0.03, f"{effect}.B": 0.02, f"{effect}.n": n}))
    grid = {c.values[2] for c in state.scan.candidates if c.name == effect}
    assert min(abs(n - point) for point in grid) > 0.1
    refined = refine(state.scan.candidates, misfit_gradients(state.scan))
    found = [c.values[2] for c in refined if c.name == effect]
    span = max(float(abs(s.record.phi_m).max()) for s in state.data.fitted) * 2
    assert min(abs(n - point) for point in found) < np.pi / span  # within the main lobe, from where a refit finds it
    refits = refit_hopeful(state.scored(Criteria()), Criteria(skip=("record_change",)), lambda _: None).refits
    assert refits[0].effect == effect
    assert refits[0].score.candidate.values[2] in found
    assert refits[0].model.parameters[f"{effect}.n"] == pytest.approx(n, rel=0.01)


@pytest.mark.parametrize("n", [209.4, 628.3])  # magnets 30 and 10 mm apart
def test_a_sliding_axis_has_periods_of_any_length(n: float) -> None:
    x = np.linspace(0.0, 0.5, 2000)
    wave = Wave(x, np.cos(n * x))
    assert min(abs(peak - n) for peak in period_peaks([wave], (1.0, 72.0), linear=True)) < 0.1 * 2 * np.pi / 0.5
    assert max(period_peaks([wave], (1.0, 72.0)), default=0.0) <= 72.0
