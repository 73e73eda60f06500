"""A law that no effect of the catalogue is: the curve that explains most lies along what the law depends on."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.nonparametric.curve_fit import fit_curves
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.pipeline.execute import execute
from study.conditional.plan import PLAIN, Spec
from study.conditional.trial import prepared
from study.trials.tool import fit

DRAW = 201
"""Far from the numbers that a study draws."""
LAWS = {
    "quadratic_gear_damping": (Spec(PLAIN, "stranger", "quadratic_gear_damping", DRAW), "dtwist"),
    "stiffness_by_angle": (Spec(PLAIN, "stranger", "stiffness_by_angle", DRAW), "phi_m, by twist"),
}
"""What is hidden, and along what it acts."""


@pytest.mark.parametrize("law", LAWS)
def test_a_law_that_is_in_no_catalogue_is_told_by_what_it_depends_on(law: str, tmp_path: Path) -> None:
    spec, along = LAWS[law]
    prepared(spec)[0].write(tmp_path)
    run = fit(tmp_path / "base.yaml").run
    found, records = execute(run, "fit").content, execute(run, "collect").content.records
    model = fitted_model(found.models[found.best])
    fitted = [simulate_record(model, record) for record in records if record.name in model.records]
    held_out = [record for record in records if record.name not in model.records]
    state = first_state(Evidence(model, fitted, held_out), Criteria())
    assert fit_curves(state.model, state.data)[0].curve.along == along
