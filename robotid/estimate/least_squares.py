"""Bounded Gauss-Newton with Levenberg-Marquardt damping (Nocedal & Wright 2006, section 10.3; bounds by active set).

Steps are taken in columns scaled to unit norm. Of the Jacobian only the triangular factor is kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.result import End
from robotid.model.array import Array, Mask
from robotid.progress import Iteration

SMALLEST_DAMPING, LARGEST_DAMPING = 1e-14, 1e10
FIRST_DAMPING = 1e-3
SLOWEST_GROWTH = 4  # of the damping at a step in vain; twice as fast at each further one (Nielsen 1999)
IN_NOISE = 0.1  # of the decrease that fitting pure noise brings, unknowns / samples: less is not worth a step
MOST_SMALL = 3  # steps in a row that gain less than they promised and less than the tolerance


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """Where the iteration ended.

    factor : (m, m) upper triangular with factor^T factor = J^T J at the end.
    """

    evaluation: Evaluation
    factor: Array
    cost: tuple[float, ...]
    end: End


def solve(
    problem: OutputError,
    start: Array,
    *,
    most: int = 50,
    tolerance: float = 1e-8,
    log: Callable[[Iteration], None] | None = None,
    known: Evaluation | None = None,
    most_small: int = MOST_SMALL,
    interruptible: bool = False,
) -> Solution:
    """Minimise the problem's cost from start (m,). known : its evaluation there, where there is one; most_small : steps
    in a row that may gain less than they promised and less than the tolerance; interruptible : an interrupt from the
    keyboard ends the iteration with the last iterate, rather than all.

    Converged when the decrease that a full step promises is below tolerance times the cost, or when steps stall
    (friction leaves kinks) at a promise lost in the noise; stalled, too, before an iterate without finite derivatives.
    Raises NumericsError where the very first simulation diverges.
    """
    lower, upper = problem.bounds()
    at = problem.evaluate(np.clip(start, lower, upper)) if known is None else known
    if not len(start):
        return Solution(at, np.zeros((0, 0)), (at.cost,), End.CONVERGED)
    factor, gradient = linearise(problem, at)
    damping, costs, end, small = FIRST_DAMPING, [at.cost], End.ITERATIONS, 0
    in_noise = IN_NOISE * len(start) / sum(map(len, at.residuals))
    try:
        for number in range(1, most + 1):
            promised = _promise(factor, gradient, _held(at, gradient, lower, upper)) / max(at.cost, 1e-300)
            if promised < tolerance:
                end = End.CONVERGED
                break
            stuck = small == most_small
            step = None if stuck else _improve(problem, at, factor, gradient, damping, (lower, upper))
            if step is None:
                end = End.CONVERGED if promised < in_noise else End.STALLED
                break
            after, damping = step
            try:
                factor, gradient = linearise(problem, after)
            except NumericsError:
                end = End.STALLED
                break
            decrease = at.cost - after.cost
            small = small + 1 if decrease < tolerance * at.cost else 0
            at = after
            costs.append(at.cost)
            if log is not None:
                log(Iteration(number, at.cost, decrease))
    except KeyboardInterrupt:
        if not interruptible:
            raise
        end = End.INTERRUPTED
    return Solution(at, factor, tuple(costs), end)


def linearise(problem: OutputError, at: Evaluation) -> tuple[Array, Array]:
    """Triangular factor (m, m) of the Jacobian at an evaluation, and the gradient J^T r (m,)."""
    m = len(at.unknowns)
    factor, gradient = np.zeros((0, m)), np.zeros(m)
    for k, residual in enumerate(at.residuals):
        where, jacobian = problem.jacobian(at, k)
        block = np.zeros((len(where), m))
        block[:, where] = np.linalg.qr(jacobian.T, mode="r")
        factor = np.asarray(np.linalg.qr(np.vstack([factor, block]), mode="r"))
        gradient[where] += jacobian @ residual
    return factor, gradient


def _held(at: Evaluation, gradient: Array, lower: Array, upper: Array) -> Mask:
    """Unknowns at a bound that the descent would cross, (m,)."""
    x = at.unknowns
    return np.asarray(((x <= lower) & (gradient > 0)) | ((x >= upper) & (gradient < 0)))


def _newton_step(factor: Array, gradient: Array, held: Mask, damping: float) -> Array:
    scale = np.linalg.norm(factor, axis=0)
    free = ~held & (scale > 0)
    step = np.zeros(len(gradient))
    if free.any():
        scaled = factor[:, free] / scale[free]
        normal = np.vstack([scaled, np.sqrt(damping) * np.eye(int(free.sum()))])
        r = np.asarray(np.linalg.qr(normal, mode="r"))
        goal = np.linalg.lstsq(r.T, -gradient[free] / scale[free], rcond=None)[0]
        step[free] = np.linalg.lstsq(r, goal, rcond=None)[0] / scale[free]
    return step


def _promise(factor: Array, gradient: Array, held: Mask) -> float:
    """Decrease of the cost that the linear model promises of an undamped step."""
    step = _newton_step(factor, gradient, held, SMALLEST_DAMPING)
    return float(-0.5 * gradient @ step)


def _improve(
    problem: OutputError, at: Evaluation, factor: Array, gradient: Array, damping: float, bounds: tuple[Array, Array]
) -> tuple[Evaluation, float] | None:
    """The next iterate and its damping, or None where no damping finds a lower cost."""
    held, growth = _held(at, gradient, *bounds), SLOWEST_GROWTH
    while damping < LARGEST_DAMPING:
        step = np.clip(at.unknowns + _newton_step(factor, gradient, held, damping), *bounds) - at.unknowns
        promised = -(gradient @ step) - 0.5 * float(np.sum((factor @ step) ** 2))
        if promised > 1e-14 * at.cost:  # cut off at its bounds, a step may lead uphill; a shorter one does not
            try:
                after = problem.evaluate(at.unknowns + step, at, most=at.cost)
            except NumericsError:
                damping = max(10 * damping, 1e-3)
                continue
            gain = (at.cost - after.cost) / promised
            if gain > 1e-4:
                return after, max(SMALLEST_DAMPING, damping / (10 if gain > 0.75 else 1 if gain > 0.25 else 0.25))
        damping, growth = max(growth * damping, 1e-6), 2 * growth
    return None
