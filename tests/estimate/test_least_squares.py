"""Steps of the iteration: cut off by their bounds, refused, and given up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from robotid.errors import NumericsError
from robotid.estimate.damping import DampedSteps, damped_step
from robotid.estimate.least_squares import Bounds, Point, SolveOptions, linearise, next_iterate, solve
from robotid.estimate.residual import Evaluation, Jacobian, Linearisation
from robotid.estimate.result import End
from robotid.model.array import Array


@dataclass
class Linear:
    """Residuals J x - b within bounds, as far as the iteration asks."""

    J: Array
    b: Array
    lower: Array

    def bounds(self) -> tuple[Array, Array]:
        return self.lower.copy(), np.full(len(self.lower), np.inf)

    def evaluate(self, unknowns: Array, near: Linearisation | None = None, *, max_cost: float = np.inf) -> Evaluation:
        return Evaluation(unknowns, (self.J @ unknowns - self.b,), ())

    def predicts(self, k: int) -> bool:
        return True

    def steps(self, at: Evaluation) -> list[None]:
        return [None]

    def jacobian(self, at: Evaluation, k: int, steps: None) -> Jacobian:
        return Jacobian(np.arange(len(at.unknowns)), self.J.T)


def test_a_step_that_its_bounds_turn_uphill_is_shortened() -> None:
    J = np.array([[1.0, 0.99], [0.0, 0.141]])
    problem = Linear(J, J @ np.array([-10.0, 9.0]), np.array([-0.1, -np.inf]))
    whole = np.array([-0.1, 9.0])
    start = problem.evaluate(np.zeros(2))
    assert problem.evaluate(whole).cost > start.cost
    solution = solve(problem, np.zeros(2), SolveOptions(tolerance=1e-12))  # type: ignore[arg-type]
    held = -0.1, float(J[:, 1] @ (problem.b + 0.1 * J[:, 0]) / (J[:, 1] @ J[:, 1]))
    assert solution.end is End.CONVERGED
    assert solution.evaluation.unknowns == pytest.approx(held, rel=1e-5)


class Explosive(Linear):
    """The same, but that derivatives are finite at the start alone."""

    def jacobian(self, at: Evaluation, k: int, steps: None) -> Jacobian:
        if at.unknowns.any():
            raise NumericsError("the derivatives are not finite")
        return super().jacobian(at, k, steps)


def test_it_ends_before_an_iterate_without_finite_derivatives() -> None:
    problem = Explosive(np.eye(2), np.array([1.0, 2.0]), np.full(2, -np.inf))
    solution = solve(problem, np.zeros(2))  # type: ignore[arg-type]
    assert solution.end is End.STALLED
    assert not solution.evaluation.unknowns.any()
    assert np.abs(solution.factor) == pytest.approx(np.eye(2))


class Kinked(Linear):
    """The same at the start alone: every step away from it makes the cost larger, however short it is."""

    tried = 0

    def evaluate(self, unknowns: Array, near: Linearisation | None = None, *, max_cost: float = np.inf) -> Evaluation:
        self.tried += 1
        return Evaluation(unknowns, (-self.b * (1.0 + np.abs(unknowns)),), ())


def test_no_step_is_tried_that_promises_less_than_the_tolerance() -> None:
    def tried(tolerance: float) -> int:
        problem = Kinked(np.eye(2), np.array([1.0, 2.0]), np.full(2, -np.inf))
        solution = solve(problem, np.zeros(2), SolveOptions(tolerance=tolerance))  # type: ignore[arg-type]
        assert solution.end is End.STALLED
        assert not solution.evaluation.unknowns.any()
        return problem.tried

    assert tried(0.5) < tried(1e-2) < tried(1e-8)


def test_a_damping_that_leaves_no_promise_is_lowered_first() -> None:
    problem = Linear(np.eye(2), np.array([1.0, 2.0]), np.full(2, -np.inf))
    start = problem.evaluate(np.zeros(2))
    at = linearise(problem, start)  # type: ignore[arg-type]
    least = 0.5 * start.cost
    tried = next(next_iterate(at, 1e6, Bounds(*problem.bounds()), least))
    assert isinstance(tried, Point)
    assert start.cost - problem.evaluate(tried.unknowns).cost >= least  # a linear problem keeps what it promises


COLUMNS = np.array([[1.0, 0.95], [0.0, 0.3]])


def _tried_after(rise: float | None, damping: float) -> tuple[Array, Array]:
    """The step of this damping and the one tried next, where the cost rises by this share of the slope; None: where it
    cannot be simulated."""
    problem = Linear(COLUMNS, np.array([1.0, -2.0]), np.full(2, -np.inf))
    at = linearise(problem, problem.evaluate(np.zeros(2)))  # type: ignore[arg-type]
    course = next_iterate(at, damping, Bounds(*problem.bounds()), 0.0)
    first = next(course)
    assert isinstance(first, Point)
    if rise is None:
        second = course.throw(NumericsError("the simulation diverges"))
    else:
        cost = at.evaluation.cost - rise * float(at.gradient @ first.unknowns)
        second = course.send(Evaluation(first.unknowns, (np.array([np.sqrt(2.0 * cost)]),), ()))
    assert isinstance(second, Point)
    return first.unknowns, second.unknowns


@pytest.mark.parametrize("damping", [1e-12, 1e-3, 10.0])
@pytest.mark.parametrize(("rise", "share"), [(0.25, 0.4), (1.0, 0.25), (0.0, 0.5), (100.0, 0.1), (None, 0.1)])
def test_a_step_without_gain_is_followed_by_one_to_where_a_parabola_is_lowest(
    rise: float | None, share: float, damping: float
) -> None:
    lengths = np.linalg.norm(COLUMNS, axis=0)
    before, after = (float(np.linalg.norm(lengths * step)) for step in _tried_after(rise, damping))
    assert share * before * 0.999 <= after <= 1.05 * share * before


def test_the_damping_of_a_length_is_found_as_closely_as_is_worth_it() -> None:
    problem = Linear(COLUMNS, np.array([1.0, -2.0]), np.full(2, -np.inf))
    at = linearise(problem, problem.evaluate(np.zeros(2)))  # type: ignore[arg-type]
    steps = DampedSteps.of(at, np.zeros(2, dtype=bool))
    lengths = np.linalg.norm(COLUMNS, axis=0)
    shares = np.linspace(0.1, 0.9, 33)
    whole = float(np.linalg.norm(lengths * steps.at(1e-3)))
    found = np.array([np.linalg.norm(lengths * steps.at(steps.damping_of(share, 1e-3))) for share in shares])
    excess = found / (shares * whole) - 1.0
    assert np.all((excess >= -1e-9) & (excess <= 0.05))
    assert excess.max() > 0.03


def test_a_damped_step_solves_the_damped_normal_equations() -> None:
    problem = Linear(COLUMNS, np.array([1.0, -2.0]), np.full(2, -np.inf))
    at = linearise(problem, problem.evaluate(np.array([0.5, 0.2])))  # type: ignore[arg-type]
    normal = at.factor.T @ at.factor
    damped = normal + 0.3 * np.diag(np.diag(normal))
    assert damped_step(at, np.zeros(2, dtype=bool), 0.3) == pytest.approx(-np.linalg.solve(damped, at.gradient))
    assert damped_step(at, np.array([True, False]), 0.3)[0] == 0.0


@dataclass
class Vanishing(Linear):
    """The logarithm of a positive unknown: from far above, a straight line leads below zero."""

    def evaluate(self, unknowns: Array, near: Linearisation | None = None, *, max_cost: float = np.inf) -> Evaluation:
        if unknowns[0] < 1e-2:
            raise AssertionError("a step took the unknown away")
        return Evaluation(unknowns, (np.log(unknowns),), ())

    def jacobian(self, at: Evaluation, k: int, steps: None) -> Jacobian:
        return Jacobian(np.arange(1), 1.0 / at.unknowns[:, None])


def test_what_is_positive_falls_to_a_tenth_at_most_in_one_step() -> None:
    bounds = Bounds(np.array([1e-9, 0.0, -np.inf, 0.3]), np.full(4, np.inf))
    before = np.array([2.0, 2.0, 2.0, 2.0])
    assert bounds.stepped(before, np.full(4, -5.0)) == pytest.approx([0.2, 0.0, -3.0, 0.3])
    assert np.array_equal(bounds.stepped(before, np.full(4, -1.5)), np.full(4, 0.5))


def test_a_mass_that_a_step_would_take_away_comes_back() -> None:
    problem = Vanishing(np.zeros((1, 1)), np.zeros(1), np.array([1e-9]))
    solution = solve(problem, np.array([40.0]))  # type: ignore[arg-type]
    assert solution.evaluation.unknowns == pytest.approx([1.0], rel=1e-3)


@dataclass
class Hindered(Linear):
    """The same where it can be simulated only close to the last point that was."""

    farthest: float = 1e-4

    def __post_init__(self) -> None:
        self.last = np.zeros(self.J.shape[1])

    def evaluate(self, unknowns: Array, near: Linearisation | None = None, *, max_cost: float = np.inf) -> Evaluation:
        if np.abs(unknowns - self.last).max() > self.farthest:
            raise NumericsError("the simulation settles too slowly to be of use")
        self.last = unknowns
        return super().evaluate(unknowns, near, max_cost=max_cost)


@pytest.mark.parametrize(("farthest", "end"), [(1e-4, End.STALLED), (10.0, End.CONVERGED)])
def test_a_fit_does_not_creep_along_what_can_be_simulated_by_less_than_noise(farthest: float, end: End) -> None:
    noise = 30.0 * (-1.0) ** np.arange(1000)
    problem = Hindered(np.ones((1000, 1)), 1.0 + noise, np.array([-np.inf]), farthest)
    solution = solve(problem, np.zeros(1), SolveOptions())  # type: ignore[arg-type]
    assert solution.end is end
    assert len(solution.cost) <= 4
    assert solution.evaluation.unknowns[0] == pytest.approx(1.0 if end is End.CONVERGED else 0.0, abs=1e-3)
