"""Steps of the iteration: where they may go, and what becomes of those that are cut off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from small_bench import fitted, records

from robotid.estimate.least_squares import solve
from robotid.estimate.residual import FARTHEST, Evaluation, OutputError
from robotid.estimate.result import End
from robotid.model.array import Array
from robotid.simulate.assemble import assemble


@dataclass
class Linear:
    """Residuals J x - b within bounds, as far as the iteration asks."""

    J: Array
    b: Array
    lower: Array

    def bounds(self) -> tuple[Array, Array]:
        return self.lower.copy(), np.full(len(self.lower), np.inf)

    def reach(self, unknowns: Array) -> tuple[Array, Array]:
        return self.bounds()

    def evaluate(self, unknowns: Array, near: Evaluation | None = None, *, most: float = np.inf) -> Evaluation:
        return Evaluation(unknowns, (self.J @ unknowns - self.b,), ())

    def jacobian(self, at: Evaluation, k: int) -> tuple[Array, Array]:
        return np.arange(len(at.unknowns)), self.J.T


def test_a_step_that_its_bounds_turn_uphill_is_shortened() -> None:
    J = np.array([[1.0, 0.99], [0.0, 0.141]])
    problem = Linear(J, J @ np.array([-10.0, 9.0]), np.array([-0.1, -np.inf]))
    whole = np.array([-0.1, 9.0])
    start = problem.evaluate(np.zeros(2))
    assert problem.evaluate(whole).cost > start.cost
    solution = solve(problem, np.zeros(2), tolerance=1e-12)  # type: ignore[arg-type]
    held = -0.1, float(J[:, 1] @ (problem.b + 0.1 * J[:, 0]) / (J[:, 1] @ J[:, 1]))
    assert solution.end is End.CONVERGED
    assert solution.evaluation.unknowns == pytest.approx(held, rel=1e-5)


def test_a_step_takes_the_shape_of_an_effect_no_farther_than_its_column_holds() -> None:
    made = records({})
    structure = fitted(made).structure.extended("motor.stribeck")
    parameters = assemble(structure).parameters()
    problem = OutputError(assemble(structure), parameters, tuple(made), "speed", np.ones(len(made)))
    unknowns = problem.start()
    shape = problem.joint.names.index("motor.stribeck.vs")
    (lower, upper), (lowest, highest) = problem.reach(unknowns), problem.bounds()
    assert lower[shape] == pytest.approx(unknowns[shape] / FARTHEST)
    assert upper[shape] == pytest.approx(unknowns[shape] * FARTHEST)
    others = np.arange(len(unknowns)) != shape
    np.testing.assert_array_equal(lower[others], lowest[others])
    np.testing.assert_array_equal(upper[others], highest[others])
