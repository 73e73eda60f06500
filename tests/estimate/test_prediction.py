"""How the trajectories of a point nearby are carried on to the next one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.estimate.least_squares import Linearisation, linearise
from robotid.estimate.residual import OutputError
from robotid.signals.record import Record


@pytest.fixture(scope="module")
def near() -> tuple[OutputError, Linearisation]:
    """The paper's joint under a sine of torque, with its derivatives."""
    t = np.arange(1500) * SAMPLING_TIME
    u = 4.0 * np.sin(2 * np.pi * 5.0 * t)
    joint = assemble(STRUCTURE)
    record = Record("sine", "estimate", "both", SAMPLING_TIME, u, 0 * u, 0 * u)
    problem = OutputError(joint, joint.parameters().with_values(TRUTH), (record,), "speed", np.ones(1))
    return problem, linearise(problem, problem.evaluate(problem.start()))


def test_a_small_step_is_predicted_to_first_order(near: tuple[OutputError, Linearisation]) -> None:
    problem, at = near
    unknowns = at.evaluation.unknowns.copy()
    unknowns[:3] *= 1.0001
    guess = problem._predict(0, at, unknowns)
    exact = problem.evaluate(unknowns).trajectories[0].x
    start = at.evaluation.trajectories[0].x
    assert np.linalg.norm(guess - exact) < 0.05 * np.linalg.norm(start - exact)


def test_derivatives_larger_than_the_motion_predict_nothing(near: tuple[OutputError, Linearisation]) -> None:
    problem, at = near
    unknowns = at.evaluation.unknowns.copy()
    unknowns[0] *= 1.01
    x, states = at.evaluation.trajectories[0].x, at.states[0]
    assert states is not None
    change = (unknowns[0] - at.evaluation.unknowns[0]) * states[1, 0]
    size = np.sqrt(np.mean(x[1] ** 2) / np.mean(change**2))
    for factor, moves in ((0.9 * size, True), (1.1 * size, False), (1e200 * size, False)):
        chaotic = states.copy()
        chaotic[:] = 0.0
        chaotic[1] = factor * states[1]
        guess = problem._predict(0, replace(at, states=(chaotic,)), unknowns)
        assert bool((guess != x).any()) is moves
