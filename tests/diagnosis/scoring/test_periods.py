"""Numbers of periods a turn are read off the misfit, between the points of any grid."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_bench import bench, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.scoring.candidates import candidates
from robotid.diagnosis.scoring.periods import periods
from robotid.diagnosis.scoring.ranking import look, rank, residual_gradients
from robotid.diagnosis.search.refits import refit_hopeful


@pytest.mark.parametrize(
    ("effect", "n"), [("motor.cogging", 7.3), ("motor.position_friction", 2.6), ("motor.position_friction", 5.15)]
)
def test_the_number_of_periods_is_found_between_the_points_of_the_grid(effect: str, n: float) -> None:
    benched, trial = bench(records({f"{effect}.A": 0.03, f"{effect}.B": 0.02, f"{effect}.n": n}))
    missing = candidates(trial.structure, benched.output)
    grid = {c.values[2] for c in missing if c.name == effect}
    assert min(abs(n - point) for point in grid) > 0.1
    looked = look(trial, ())
    gradients = residual_gradients(looked, benched)
    found = [c.values[2] for c in periods(missing, trial, benched.fitted, gradients) if c.name == effect]
    span = max(float(abs(r.phi_m).max()) for r in benched.fitted) * 2
    assert min(abs(n - point) for point in found) < np.pi / span  # within the main lobe, from where a refit finds it
    seen = rank(looked, benched, Criteria())
    tried = refit_hopeful(trial, seen, benched, Criteria(skip=("record_change",)), lambda _: None)
    assert tried[0][0].candidate.name == effect
    assert tried[0][0].candidate.values[2] in found
    assert tried[0][1].parameters[f"{effect}.n"] == pytest.approx(n, rel=0.01)
