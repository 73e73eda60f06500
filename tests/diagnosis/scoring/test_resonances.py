"""The frequency of a resonance narrower than the gaps of the grid is read off the misfit."""

from __future__ import annotations

import numpy as np
import pytest
from support.judged_records import CONTROLLER, SAMPLES
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH, references

from robotid.catalogue import assemble
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.refits import refit_hopeful
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

TOOL = {"link.third_mass.Jb": 15.0, "link.third_mass.wb": 67.0, "link.third_mass.zeta": 0.012}
TERMS = Criteria(skip=("record_change",))


def test_a_narrow_resonance_is_found_between_the_points_of_the_grid() -> None:
    joint = assemble(STRUCTURE.extended("link.third_mass"), angle=True)
    theta = joint.parameters().with_values(TRUTH | TOOL).values
    plant = VirtualRobot(joint, theta, CONTROLLER, 0.0, 0.005, 0.02, 1)
    made = [Reference(f"set{k}", SAMPLING_TIME, ref[: 2 * SAMPLES], "speed") for k, ref in enumerate(references()[1:])]
    records = [plant.record(reference, k) for k, reference in enumerate(made)]
    lean = assemble(STRUCTURE)
    model = fitted_model(fit_model("m", lean, lean.parameters().with_values(TRUTH), records, FitOptions()))
    state = first_state(Evidence(model, [simulate_record(model, r) for r in records], []), TERMS).scored(TERMS)
    grid = {c.values[1] for c in state.scan.candidates if c.name == "link.third_mass"}
    assert min(abs(67.0 - point) for point in grid) > 5.0
    seen = state.round
    assert seen.scores[0].candidate.name == "link.third_mass"
    assert seen.scores[0].candidate.values[1] == pytest.approx(67.0, rel=0.02)
    of_grid = [s.energy for s in seen.scores if s.candidate.name == "link.third_mass" and s.candidate.values[1] in grid]
    assert seen.scores[0].energy > 2.0 * np.max(of_grid)
    best = refit_hopeful(state, TERMS, lambda _: None).refits[0]
    assert best.effect == "link.third_mass"
    for name, value in TOOL.items():
        assert best.model.parameters[name] == pytest.approx(value, rel=0.1)
