"""TrajectoryNewton: a solver for scipy's solve_ivp whose one step is a window of many samples.

All nodes of a window are unknowns at once. Newton's matrix is block bidiagonal, and one banded solve yields the step
of all nodes. The problem is causal: nodes that have settled stay settled whatever comes after them, so a window that
converges in part advances by that part.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver, solve_ivp

from robotid.errors import NumericsError
from robotid.interrupt import check
from robotid.model.array import Array
from robotid.simulation.friction.step import Steps
from robotid.simulation.newton.block_bidiagonal import solve_block_bidiagonal
from robotid.simulation.newton.problem import WindowProblem

MAX_ITERATIONS = 40  # in one window; each settles more of its nodes
MAX_IDLE_ITERATIONS = 10  # in a row in which no further node settles
QUICK_ITERATIONS = 5  # a window that needs no more may grow
SLOW_ITERATIONS = 15  # beyond the quick ones, over all windows, that count as much as a window that fails
MAX_WINDOW = 16_000  # samples whose Jacobians are in memory at once
SHORT_WINDOW = 500  # samples; so short a window need not be as quick to grow, and is not divided
MIN_WINDOW = 8  # samples; where even these fail, the fallback integrates them
MAX_STATE = 1e9  # rad, rad/s: no machine gets there
MIN_SCALE = 1e-12  # of a state that does not move

_solve_ivp: Any = solve_ivp  # its types know no options of other people's solvers
Fallback = Callable[[int, int, Array], Array]
"""Integrates intervals first .. stop - 1 from a state (states,): (first, stop, start) -> (states, stop - first + 1)."""


T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """Intervals first .. last - 1 of a problem at their nodes x (states, last - first + 1)."""

    problem: WindowProblem
    first: int
    last: int
    x: Array


Course = Generator[Window, Array, T]
"""A computation that asks for the Newton steps (states, nodes) of one window after the other."""


@dataclass(frozen=True, slots=True, eq=False)
class NewtonResult:
    """Nodes x (states, m + 1) of a window, how many of its intervals have settled, and the iterations that it took."""

    x: Array
    settled: int
    iterations: int


def integrate(problem: WindowProblem, x0: Array, fallback: Fallback) -> Array:
    """All nodes of a problem from its first state x0 (states,), (states, n + 1).

    fallback : integrates the few samples at which Newton's method fails. Raises NumericsError on divergence.
    """
    n, h = problem.intervals, problem.sampling_time
    solution = _solve_ivp(
        _never_called,
        (0.0, n * h),
        x0,
        method=TrajectoryNewton,
        t_eval=np.arange(n + 1) * h,
        problem=problem,
        fallback=fallback,
    )
    if not solution.success or not np.isfinite(solution.y).all():
        raise NumericsError("the simulation diverges", hint="check the parameters' guesses and bounds")
    return np.asarray(solution.y)


def integrating(problem: WindowProblem, x0: Array, fallback: Fallback) -> Course[tuple[Array, int]]:
    """The course of what `integrate` does, with the least max_failed_windows that allows it."""
    solver = TrajectoryNewton(
        _never_called, 0.0, x0, problem.intervals * problem.sampling_time, problem=problem, fallback=fallback
    )
    x = np.empty((len(x0), problem.intervals + 1))
    x[:, 0] = x0
    while solver.node < problem.intervals:
        yield from solver.stepping()
        x[:, solver.first : solver.node + 1] = solver.x
    if not np.isfinite(x).all():
        raise NumericsError("the simulation diverges", hint="check the parameters' guesses and bounds")
    return x, solver.needed_failures


@np.errstate(all="ignore")  # an iterate may overflow before its window is shortened
def followed(course: Course[T]) -> T:
    """The end of a course."""
    try:
        window = next(course)
        while True:
            check()
            steps = window.problem.linearise(window.first, window.last, window.x)
            window = course.send(newton_step(steps))
    except StopIteration as end:
        found: T = end.value
        return found


def _never_called(t: float, x: Array) -> Array:
    """solve_ivp asks for a right-hand side; this solver takes the joint's, with its derivatives, from the problem."""
    raise NotImplementedError


def state_scale(x: Array) -> Array:
    """The size of each state along a trajectory x (states, n), (states,)."""
    return np.asarray(np.maximum(np.maximum(x.max(axis=1), -x.min(axis=1)), MIN_SCALE))


def newton(problem: WindowProblem, first: int, start: Array, guess: Array, scale: Array) -> Course[NewtonResult]:
    """The course of one window from its known first state.

    start : (states,) at node `first`; guess : (states, m + 1); scale : (states,) the size of the trajectory, relative
    to which a Newton step counts as small.
    """
    x = guess.copy()
    x[:, 0] = start
    joint = problem.joint
    limits = {row: max(limit, abs(start[row])) for row, limit in joint.state_limits.items()}
    dry = [joint.speeds.start + j for j in joint.dry]
    settled, last, idle = 0, guess.shape[1] - 1, 0
    for iteration in range(1, MAX_ITERATIONS + 1):
        active = x[:, settled : last + 1]
        change = yield Window(problem, first + settled, first + last, active)
        finite = np.asarray(np.isfinite(change).all(axis=0))
        whole = len(finite) if finite.all() else int(np.argmin(finite))
        before = active[dry]
        active[:, :whole] += change[:, :whole]
        reversed_ = before * active[dry] < 0.0
        active[dry] = np.where(reversed_, 0.0, active[dry])
        for row, limit in limits.items():
            np.clip(active[row], -limit, limit, out=active[row])
        size = np.maximum(np.maximum.accumulate(np.abs(active[:, :whole]), axis=1), scale[:, None])
        small = np.asarray((np.abs(change[:, :whole]) <= problem.tolerance * size).all(axis=0))
        gained = whole - 1 if small.all() else int(np.argmin(small)) - 1
        settled, idle = settled + gained, 0 if gained else idle + 1
        if settled == last or whole < len(finite) or idle == MAX_IDLE_ITERATIONS:
            break
        if iteration >= QUICK_ITERATIONS and last - settled > SHORT_WINDOW:
            last = settled + (last - settled) // 2
    return NewtonResult(x, settled, iteration)


def newton_step(steps: Steps) -> Array:
    """The step of all nodes of a window, (states, nodes)."""
    rhs = np.zeros((len(steps.c), 1, steps.c.shape[1] + 1))
    rhs[:, 0, 1:] = steps.c
    return np.asarray(solve_block_bidiagonal(steps.G, rhs)[:, 0])


class Nodes(DenseOutput):
    """A window's solution at its samples."""

    def __init__(self, t_old: float, t: float, sampling_time: float, first: int, x: Array) -> None:
        super().__init__(t_old, t)
        self.first, self.x, self.sampling_time = first, x, sampling_time

    def _call_impl(self, t: Array) -> Array:
        nearest = np.rint(np.asarray(t) / self.sampling_time).astype(int) - self.first
        return np.asarray(self.x[:, nearest])


class TrajectoryNewton(OdeSolver):
    """Window after window of a problem; `fallback` integrates the few samples at which Newton's method fails.

    node : the sample reached; window : how many samples the next step tries; scale : (states,) the size of the states
    so far.
    """

    def __init__(
        self,
        fun: Callable[..., Any],
        t0: float,
        y0: Array,
        t_bound: float,
        vectorized: bool = False,
        *,
        problem: WindowProblem,
        fallback: Fallback,
    ) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized)
        # scipy's own refer to the solver: in a cycle, the arrays of a problem would outlive it by far
        self.fun = self.fun_single = self.fun_vectorized = fun
        self.problem, self.fallback = problem, fallback
        self.node, self.window = 0, problem.first_window
        self.failed_windows = self.slow_iterations = 0
        self.scale = state_scale(problem.guess)
        self.x = self.y[:, None]
        self.first = 0

    def _step_impl(self) -> tuple[bool, str | None]:
        followed(self.stepping())
        return True, None

    def stepping(self) -> Course[None]:
        """The course of one step."""
        problem, total = self.problem, self.problem.intervals
        guess = problem.guess[:, self.node : self.node + self.window + 1]
        while True:
            check()
            stop = min(total, self.node + self.window)
            found = yield from newton(problem, self.node, self.y, guess, self.scale)
            self.nfev += 3 * found.iterations
            whole = found.settled == stop - self.node
            self._count(found, failed=not whole)
            if whole or found.settled >= MIN_WINDOW:
                self._advance(found.x[:, : found.settled + 1])
                self.window = self._next_window(found, whole=whole)
                return
            if self.window <= MIN_WINDOW:
                break
            self.window = max(MIN_WINDOW, self.window // 4)
            # What did not lead there may be far off; over a short window, so little happens that rest is a fair guess.
            guess = np.repeat(self.y[:, None], min(self.window, total - self.node) + 1, axis=1)
        stop = min(total, self.node + MIN_WINDOW)
        self._advance(self.fallback(self.node, stop, self.y))
        self.window = 4 * MIN_WINDOW

    @property
    def needed_failures(self) -> int:
        """The least max_failed_windows that allows what there was so far."""
        return max(self.failed_windows, -(-self.slow_iterations // SLOW_ITERATIONS) - 1)

    def _count(self, found: NewtonResult, *, failed: bool) -> None:
        limit = self.problem.max_failed_windows
        self.failed_windows += failed
        self.slow_iterations += max(0, found.iterations - QUICK_ITERATIONS)
        if limit is not None and self.needed_failures > limit:
            raise NumericsError(
                "the simulation settles too slowly to be of use", hint="check the parameters' guesses and bounds"
            )

    def _next_window(self, found: NewtonResult, *, whole: bool) -> int:
        """Longer where Newton's method is quick, shorter where reversals slow it down."""
        if not whole:
            return max(MIN_WINDOW, found.settled)
        slow = found.iterations > 2 * QUICK_ITERATIONS
        if found.iterations <= QUICK_ITERATIONS or (self.window < SHORT_WINDOW and not slow):
            return min(MAX_WINDOW, 2 * self.window)
        return max(SHORT_WINDOW, self.window // 2) if slow else self.window

    def _advance(self, x: Array) -> None:
        problem = self.problem
        if not np.abs(x).max() < MAX_STATE:
            raise NumericsError(
                f"the simulation diverges at t = {self.node * problem.sampling_time:.4g} s",
                hint="check the parameters' guesses and bounds",
            )
        self.first, self.x = self.node, x
        self.node += x.shape[1] - 1
        self.scale = np.maximum(self.scale, np.abs(x).max(axis=1))
        self.t = self.t_bound if self.node == problem.intervals else self.node * problem.sampling_time
        self.y = x[:, -1]

    def _dense_output_impl(self) -> Nodes:
        return Nodes(self.t_old, self.t, self.problem.sampling_time, self.first, self.x)
