"""Bounded Gauss-Newton with Levenberg-Marquardt damping (Nocedal & Wright 2006, section 10.3; bounds by active set).

Steps are taken in columns scaled to unit norm. Of the Jacobian only a square factor is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.damping import (
    LONGEST,
    MAX_DAMPING,
    MIN_DAMPING,
    SHORTEST,
    DampedSteps,
    damped_step,
    lowest_along,
)
from robotid.estimate.residual import Evaluation, Linearisation, OutputError, joined_factor
from robotid.estimate.result import End
from robotid.interrupt import INTERRUPTS, check
from robotid.model.array import Array, Index, Mask
from robotid.progress import Iteration
from robotid.simulation.friction.step import Steps

T = TypeVar("T")
FIRST_DAMPING = 1e-3
DAMPING_GROWTH = 4  # of a lifted step without gain; twice as fast at each further one (Nielsen 1999)
GOOD, FAIR, POOR = 0.75, 0.25, 1e-4  # gain over predicted reduction: damping falls, stays, rises; the step is refused
NOISE_SHARE = 0.1  # of the decrease that fitting pure noise brings, unknowns / samples: less is not worth a step
NO_REDUCTION = 1e-14  # of the cost: rounding
MAX_FALL = 10.0  # factor of one step on what is positive by its bound, as masses are: no linearisation sees further


@dataclass(frozen=True, slots=True)
class SolveOptions:
    """When the iteration ends.

    tolerance : the iteration has converged once a full step would reduce the cost by less than this, relative to it.
    max_small_steps : how many steps in a row may reduce the cost by less than that although they predicted more, as
    they do where friction leaves kinks; where longer ones could not be simulated, also by less than what fitting noise
    brings. steady : share of the cost by which an iteration beyond the largest number must have lowered it for another
    one, up to `further` of them: in a narrow valley none gets far, and each gets on. interruptible : an interrupt from
    the keyboard ends the iteration with the last iterate, not the program.
    """

    max_iterations: int = 50
    tolerance: float = 1e-8
    max_small_steps: int = 3
    steady: float = 1.0
    further: int = 0
    interruptible: bool = False

    def goes_on(self, cost: Sequence[float]) -> bool:
        """Whether an iteration may follow these, by the cost at the start and after each."""
        beyond = len(cost) - 1 - self.max_iterations
        return beyond < 0 or (beyond < self.further and cost[-2] - cost[-1] > self.steady * cost[-2])


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """Where the iteration ended.

    factor : (m, m) with factor^T factor = J^T J at the end; cost : at the start and after each step; direct : whether
    every iterate from the given start on was simulated.
    """

    evaluation: Evaluation
    factor: Array
    cost: tuple[float, ...]
    end: End
    direct: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """Lower and upper bounds of the unknowns, (m,) each."""

    lower: Array
    upper: Array

    def clip(self, unknowns: Array) -> Array:
        """The nearest point within, (m,)."""
        return np.asarray(np.clip(unknowns, self.lower, self.upper))

    def stepped(self, before: Array, step: Array) -> Array:
        """The nearest point within to that after a step, (m,). Where the bound keeps an unknown positive, it falls by a
        factor of MAX_FALL at most: a mass that a step takes away does not come back."""
        least = np.where(self.lower > 0.0, np.maximum(self.lower, before / MAX_FALL), self.lower)
        return np.asarray(np.clip(before + step, least, self.upper))

    def active(self, at: Linearisation) -> Mask:
        """Unknowns at a bound that the descent would cross, (m,)."""
        x, gradient = at.evaluation.unknowns, at.gradient
        return np.asarray(((x <= self.lower) & (gradient > 0)) | ((x >= self.upper) & (gradient < 0)))


def solve(
    problem: OutputError,
    start: Array,
    options: SolveOptions = SolveOptions(),
    *,
    initial: Evaluation | None = None,
    log: Callable[[Iteration], None] | None = None,
) -> Solution:
    """Minimise the problem's cost from start (m,). initial : its evaluation there, where there is one.

    Converged as of the options' tolerance, or where steps stall with a predicted reduction that is lost in the noise;
    stalled before an iterate without finite derivatives. log : called after every iteration. Raises NumericsError where
    the very first simulation diverges.
    """
    return answered(problem, solving(problem, start, options, initial=initial, log=log))


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """Unknowns (m,) that are to be evaluated. near, max_cost : as of `OutputError.evaluate`."""

    unknowns: Array
    near: Linearisation | None = None
    max_cost: float = np.inf


Question = Point | Evaluation
"""What an iteration asks: the evaluation of a point, or the linearisation at an evaluation."""

Course = Generator[Question, Any, T]
"""An iteration from question to answer."""


def answered(problem: OutputError, course: Course[T]) -> T:
    """The end of an iteration whose questions are answered one by one."""
    try:
        question = next(course)
        while True:
            try:
                found = answer(problem, question)
            except BaseException as error:
                question = course.throw(error)
            else:
                question = course.send(found)
    except StopIteration as end:
        result: T = end.value
        return result


def answer(problem: OutputError, question: Question) -> Evaluation | Linearisation:
    """What an iteration asks of a problem. Raises NumericsError where it cannot be simulated there."""
    if isinstance(question, Evaluation):
        return linearise(problem, question)
    return problem.evaluate(question.unknowns, question.near, max_cost=question.max_cost)


def solving(
    problem: OutputError,
    start: Array,
    options: SolveOptions,
    *,
    initial: Evaluation | None = None,
    log: Callable[[Iteration], None] | None = None,
) -> Course[Solution]:
    """The course of `solve`."""
    bounds = Bounds(*problem.bounds())
    first = (yield Point(bounds.clip(start))) if initial is None else initial
    if not len(start):
        return Solution(first, np.zeros((0, 0)), (first.cost,), End.CONVERGED)
    damping, costs, end, small_steps = FIRST_DAMPING, [first.cost], End.ITERATIONS, 0
    in_noise = NOISE_SHARE * len(start) / sum(map(len, first.residuals))
    at = yield first
    del first, initial  # of a long record they are large, and only the latest evaluation is needed
    try:
        while options.goes_on(costs):
            check()
            reduction = predicted_reduction(at, bounds) / max(costs[-1], 1e-300)
            if reduction < options.tolerance:
                end = End.CONVERGED
                break
            stuck = small_steps == options.max_small_steps
            step = None if stuck else (yield from next_iterate(at, damping, bounds, options.tolerance * costs[-1]))
            if step is None:
                end = End.CONVERGED if reduction < in_noise else End.STALLED
                break
            after, damping, hindered = step
            try:
                at = yield after
            except NumericsError:
                end = End.STALLED
                break
            decrease = costs[-1] - after.cost
            small = max(options.tolerance, in_noise) if hindered else options.tolerance
            small_steps = small_steps + 1 if decrease < small * costs[-1] else 0
            costs.append(after.cost)
            if log is not None:
                log(Iteration(len(costs) - 1, after.cost, decrease))
    except INTERRUPTS:
        if not options.interruptible:
            raise
        end = End.INTERRUPTED
    return Solution(at.evaluation, at.factor, tuple(costs), end)


def linearise(problem: OutputError, at: Evaluation, steps: Sequence[Steps | None] | None = None) -> Linearisation:
    """A factor of the Jacobian at an evaluation, and the gradient J^T r. steps : as of `OutputError.steps`, where they
    are known. Raises NumericsError where they are not finite."""
    gradient, triangles, unknowns = np.zeros(len(at.unknowns)), list[Array](), list[Index]()
    states: list[Array | None] = []
    with np.errstate(all="ignore"):  # derivatives that are not finite are reported
        steps = problem.steps(at) if steps is None else steps
    for k, residual in enumerate(at.residuals):
        if not problem.predicts(k):
            triangle, own = _of_long_record(problem, at, k)
            triangles.append(triangle)
            unknowns.append(problem.unknowns_of(k))
            gradient[unknowns[-1]] += own
            states.append(None)
            continue
        jacobian = problem.jacobian(at, k, steps[k])
        triangles.append(np.asarray(np.linalg.qr(jacobian.values.T, mode="r")))
        unknowns.append(jacobian.unknowns)
        gradient[jacobian.unknowns] += jacobian.values @ residual
        states.append(jacobian.states)
    return Linearisation(at, joined_factor(triangles, unknowns), gradient, tuple(states))


@np.errstate(all="ignore")  # derivatives that are not finite are reported
def _of_long_record(problem: OutputError, at: Evaluation, k: int) -> tuple[Array, Array]:
    """Triangular factor (m, m) of record k's own unknowns and the gradient (m,), gathered block by block of samples."""
    m = len(problem.unknowns_of(k))
    factor, gradient, residual = np.zeros((m, m)), np.zeros(m), at.residuals[k]
    for block, values in problem.derivative_blocks(at, k):
        factor = np.asarray(np.linalg.qr(np.vstack([factor, values.T]), mode="r"))
        gradient += values @ residual[block]
    return factor, gradient


def predicted_reduction(at: Linearisation, bounds: Bounds) -> float:
    """Decrease of the cost that the linear model predicts of an undamped step."""
    return float(-0.5 * at.gradient @ damped_step(at, bounds.active(at), MIN_DAMPING))


def next_iterate(
    at: Linearisation, damping: float, bounds: Bounds, least: float
) -> Course[tuple[Evaluation, float, bool] | None]:
    """The course to the next iterate, its damping, and whether a longer step could not be simulated; or None where no
    damping finds a lower cost.

    least : decrease of the cost that a step must promise to be worth a simulation; the more it is damped, the less it
    promises. Where the damping of the step before leaves no such promise, the first step is damped less.
    """
    before, steps, hindered = at.evaluation, DampedSteps.of(at, bounds.active(at)), False
    while damping > MIN_DAMPING and _promised(at, steps.at(damping)) < least:
        damping = max(MIN_DAMPING, damping / 10)
    while damping < MAX_DAMPING:
        whole = steps.at(damping)
        if _promised(at, whole) < least:
            break
        step = bounds.stepped(before.unknowns, whole) - before.unknowns
        predicted, share = _promised(at, step), LONGEST
        if predicted > NO_REDUCTION * before.cost:  # cut off at its bounds, a step may lead uphill; a shorter one not
            try:
                after = yield Point(before.unknowns + step, at, before.cost)
            except NumericsError:
                share, hindered = SHORTEST, True
            else:
                gain = (before.cost - after.cost) / predicted
                if gain > POOR:
                    easier = max(MIN_DAMPING, damping / (10 if gain > GOOD else 1 if gain > FAIR else 0.25))
                    return after, easier, hindered
                share = lowest_along(float(at.gradient @ step), after.cost - before.cost)
        damping = steps.damping_of(share, damping)
    return None


def _promised(at: Linearisation, step: Array) -> float:
    """Decrease of the cost that the linear model predicts of a step (m,)."""
    return -float(at.gradient @ step) - 0.5 * float(np.sum((at.factor @ step) ** 2))
