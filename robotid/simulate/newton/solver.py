"""TrajectoryNewton: a solver for scipy's solve_ivp whose one step is a window of many samples.

All nodes of a window are unknowns at once. Newton's matrix is block bidiagonal; divided by its diagonal blocks it is
unit lower triangular and banded, and one LAPACK call (dtbtrs) solves the window. The problem is causal: nodes that have
settled stay settled whatever comes after them, so a window that converges in part advances by that part.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver, solve_ivp
from scipy.linalg.lapack import dtbtrs

from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.simulate.friction.steps import StepInputs, Steps, linearise

MOST_ITERATIONS = 40
MOST_IDLE = 10  # iterations in which nothing settles
LARGEST_WINDOW = 4000
SHORT_WINDOW = 500
SMALLEST_WINDOW = 8
FEW_ITERATIONS = 5
RUNAWAY = 1e9  # rad, rad/s: no machine gets there
LEAST_SCALE = 1e-12  # of a state that does not move
TOLERANCE = 1e-4  # of the last Newton step, relative; the error left is of the order of its square


@dataclass(slots=True, eq=False)
class Problem:
    """A simulation to be done: u (n,) torque held over each of the n intervals, guess (nx, n + 1) of the nodes.

    begin [s] : time of the first node. patience : how many windows may fail to settle before that counts as divergence,
    None for as many as there are. scale (nx,) grows with the trajectory: the size against which a Newton step
    counts as small, in parts of tolerance.
    """

    tolerance: ClassVar[float] = TOLERANCE
    joint: Joint
    theta: Array
    u: Array
    sampling_time: float
    guess: Array
    begin: float = field(default=0.0, kw_only=True)
    patience: int | None = field(default=None, kw_only=True)
    scale: Array = field(init=False)

    def __post_init__(self) -> None:
        self.scale = np.maximum(np.abs(self.guess).max(axis=1), LEAST_SCALE)

    def linearise(self, first: int, last: int, x: Array) -> Steps:
        """Intervals first .. last - 1 linearised at their nodes x (nx, last - first + 1)."""
        return linearise(self.motive(first, last), x[:, :-1], x[:, 1:])

    @property
    def dry(self) -> list[int]:
        """The states that are speeds under dry friction."""
        return [self.joint.speeds.start + j for j in self.joint.dry]

    def motive(self, first: int, last: int, columns: Sequence[int] | None = None) -> StepInputs:
        """What acts in intervals first .. last - 1."""
        h = self.sampling_time
        t = self.begin + np.arange(first, last, dtype=np.float64) * h
        return StepInputs(
            self.joint, self.theta, self.u[first:last], t, np.full(last - first, h, dtype=np.float64), columns
        )


def solve_block_bidiagonal(steps: Steps, columns: Array, *, back: bool = False) -> Array:
    """Solve z[n+1] = G[n] z[n] + columns[n+1] with z[0] = columns[0]. columns (nx, q, n + 1) -> the same shape.

    back : the adjoint, z[n] = G[n]' z[n+1] + columns[n], from the last.
    """
    d, q, nodes = columns.shape
    band = np.zeros((2 * d, d * nodes))
    for i in range(d):
        for j in range(d):
            band[d + i - j, j : d * (nodes - 1) : d] = -steps.G[i, j]
    rhs = columns.transpose(1, 2, 0).reshape(q, d * nodes).T
    solved, _ = dtbtrs(band, rhs, uplo="L", trans="T" if back else "N", diag="U", overwrite_b=True)
    return np.asarray(solved.T.reshape(q, nodes, d).transpose(2, 0, 1))


@np.errstate(all="ignore")  # an iterate may overflow before its window is shortened
def newton(problem: Problem, first: int, start: Array, guess: Array) -> tuple[Array, int, int]:
    """One window from its known first state. guess (nx, m + 1) -> nodes, how many intervals settled, iterations."""
    x = guess.copy()
    x[:, 0] = start
    limits = {row: max(limit, abs(start[row])) for row, limit in problem.joint.state_limits.items()}
    settled, last, idle = 0, guess.shape[1] - 1, 0
    for iteration in range(1, MOST_ITERATIONS + 1):
        active = x[:, settled : last + 1]
        change = _newton_step(problem, first + settled, first + last, active)
        finite = np.asarray(np.isfinite(change).all(axis=0))
        whole = len(finite) if finite.all() else int(np.argmin(finite))
        before = active[problem.dry]
        active[:, :whole] += change[:, :whole]
        reversed_ = before * active[problem.dry] < 0.0
        active[problem.dry] = np.where(reversed_, 0.0, active[problem.dry])
        for row, limit in limits.items():
            np.clip(active[row], -limit, limit, out=active[row])
        size = np.maximum(np.maximum.accumulate(np.abs(active[:, :whole]), axis=1), problem.scale[:, None])
        small = np.asarray((np.abs(change[:, :whole]) <= problem.tolerance * size).all(axis=0))
        gained = whole - 1 if small.all() else int(np.argmin(small)) - 1
        settled, idle = settled + gained, 0 if gained else idle + 1
        if settled == last or whole < len(finite) or idle == MOST_IDLE:
            break
        if iteration >= FEW_ITERATIONS and last - settled > SHORT_WINDOW:
            last = settled + (last - settled) // 2
    return x, settled, iteration


def _newton_step(problem: Problem, first: int, last: int, x: Array) -> Array:
    steps = problem.linearise(first, last, x)
    rhs = np.zeros((len(x), 1, x.shape[1]))
    rhs[:, 0, 1:] = steps.c
    return np.asarray(solve_block_bidiagonal(steps, rhs)[:, 0])


_solve_ivp: Any = solve_ivp  # its types know no options of other people's solvers
Rescue = Callable[[Problem, int, int, Array], Array]


class Nodes(DenseOutput):
    """A window's solution at its samples."""

    def __init__(self, t_old: float, t: float, sampling_time: float, first: int, x: Array) -> None:
        super().__init__(t_old, t)
        self.first, self.x, self.sampling_time = first, x, sampling_time

    def _call_impl(self, t: Array) -> Array:
        nearest = np.rint(np.asarray(t) / self.sampling_time).astype(int) - self.first
        return np.asarray(self.x[:, nearest])


class TrajectoryNewton(OdeSolver):
    """Window after window of a `Problem`; `rescue` integrates the few samples at which Newton's method fails."""

    def __init__(
        self,
        fun: Callable[..., Any],
        t0: float,
        y0: Array,
        t_bound: float,
        vectorized: bool = False,
        *,
        problem: Problem,
        rescue: Rescue,
    ) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized)
        self.problem, self.rescue = problem, rescue
        self.node, self.window = 0, LARGEST_WINDOW // 2
        self.unsettled = 0
        self.x = self.y[:, None]
        self.first = 0

    def _step_impl(self) -> tuple[bool, str | None]:
        problem, total = self.problem, len(self.problem.u)
        guess = problem.guess[:, self.node : self.node + self.window + 1]
        while True:
            stop = min(total, self.node + self.window)
            x, settled, iterations = newton(problem, self.node, self.y, guess)
            self.nfev += 3 * iterations
            whole = settled == stop - self.node
            self.unsettled += not whole
            if problem.patience is not None and self.unsettled > problem.patience:
                raise NumericsError("the simulation creeps", hint="check the parameters' guesses and bounds")
            if whole or settled >= SMALLEST_WINDOW:
                self._advance(x[:, : settled + 1])
                self.window = self._next_window(settled, whole, iterations)
                return True, None
            if self.window <= SMALLEST_WINDOW:
                break
            self.window = max(SMALLEST_WINDOW, self.window // 4)
            # What did not lead there may be far off; over a short window, so little happens that rest is a fair guess.
            guess = np.repeat(self.y[:, None], min(self.window, total - self.node) + 1, axis=1)
        stop = min(total, self.node + SMALLEST_WINDOW)
        self._advance(self.rescue(problem, self.node, stop, self.y))
        self.window = 4 * SMALLEST_WINDOW
        return True, None

    def _next_window(self, settled: int, whole: bool, iterations: int) -> int:
        """Longer where Newton's method is quick; shorter where reversals make it creep along the window."""
        if not whole:
            return max(SMALLEST_WINDOW, settled)
        if iterations <= FEW_ITERATIONS or (self.window < SHORT_WINDOW and iterations <= 2 * FEW_ITERATIONS):
            return min(LARGEST_WINDOW, 2 * self.window)
        return self.window if iterations <= 2 * FEW_ITERATIONS else max(SHORT_WINDOW, self.window // 2)

    def _advance(self, x: Array) -> None:
        problem = self.problem
        if not np.abs(x).max() < RUNAWAY:
            raise NumericsError(
                f"the simulation diverges at t = {self.node * problem.sampling_time:.4g} s",
                hint="check the parameters' guesses and bounds",
            )
        self.first, self.x = self.node, x
        self.node += x.shape[1] - 1
        problem.scale = np.maximum(problem.scale, np.abs(x).max(axis=1))
        self.t = self.t_bound if self.node == len(problem.u) else self.node * problem.sampling_time
        self.y = x[:, -1]

    def _dense_output_impl(self) -> Nodes:
        return Nodes(self.t_old, self.t, self.problem.sampling_time, self.first, self.x)


def integrate(problem: Problem, x0: Array, rescue: Rescue) -> Array:
    """All nodes of a problem from its first state x0 (nx,), (nx, n + 1). Raises NumericsError on divergence."""
    n, h = len(problem.u), problem.sampling_time
    solution = _solve_ivp(
        _never_called,
        (0.0, n * h),
        x0,
        method=TrajectoryNewton,
        t_eval=np.arange(n + 1) * h,
        problem=problem,
        rescue=rescue,
    )
    if not solution.success or not np.isfinite(solution.y).all():
        raise NumericsError("the simulation diverges", hint="check the parameters' guesses and bounds")
    return np.asarray(solution.y)


def _never_called(t: float, x: Array) -> Array:
    """solve_ivp asks for a right-hand side; this solver takes the joint's, with its derivatives, from the problem."""
    raise NotImplementedError
