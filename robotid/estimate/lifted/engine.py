"""The fit's engine: damped Gauss-Newton steps that move unknowns and trajectories together.

Where today's way simulates to convergence at every iterate, here the trajectories are iterates, too. Steps are those
of `least_squares` (damped after Levenberg and Marquardt, bounds by active set), judged by a merit of cost and defects.
First states stay fixed while the defects are large: a record that starts at rest would else end in another branch of
its friction. Where a step does not reduce the merit, the trajectories are made simulations at the last good iterate;
where that does not help either, `least_squares.solve` goes on from the best point.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from operator import attrgetter

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate import least_squares
from robotid.estimate.damping import MIN_DAMPING, damped_step
from robotid.estimate.least_squares import (
    DAMPING_GROWTH,
    FAIR,
    FIRST_DAMPING,
    GOOD,
    NOISE_SHARE,
    POOR,
    Bounds,
    Solution,
    SolveOptions,
    predicted_reduction,
)
from robotid.estimate.lifted.coarse import coarse_factor, coarsened, refined
from robotid.estimate.lifted.iterate import Iterate, advanced_nodes, iterate
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.result import End
from robotid.interrupt import Interrupted, check, winding_up
from robotid.model.array import Array
from robotid.progress import Iteration
from robotid.simulation.actuator import ActingTorque, acting_torque
from robotid.simulation.first_guess import follow_motor, measured_guess
from robotid.simulation.newton.problem import TOLERANCE, Problem
from robotid.simulation.simulate import trajectory_of

DEFAULTS = SolveOptions()
LARGE_DEFECT = 0.1  # of the cost: first states stay fixed
UNSETTLED = 0.01  # of the merit: nodes whose output is further from a simulation do not tell the cost
MAX_REJECTED = 1  # steps in a row: kinks, which whole simulations judge better
MAX_DERIVATIVES = 20_000_000  # kept at once


class NotSettling(NumericsError):
    """Nodes and a linearisation of their steps do not tell what a simulation does."""


@dataclass(frozen=True, slots=True)
class Ended:
    """An iterate, how the iteration to it ended, and the cost of all iterates before and at it."""

    at: Iterate
    end: End
    cost: tuple[float, ...]


def solve(
    problem: OutputError,
    start: Array,
    options: SolveOptions = DEFAULTS,
    *,
    initial: Evaluation | None = None,
    log: Callable[[Iteration], None] | None = None,
) -> Solution:
    """Minimise the problem's cost from start (m,). Arguments, result and errors as of `least_squares.solve`.

    initial : where the start is simulated already, whole simulations close by need an iteration or two, and go on. The
    costs of iterates before the last are those to be expected of a simulation.
    """
    cost, direct = tuple[float, ...](), True
    if initial is None and len(start) and fits_in_memory(problem):
        try:
            ended = _solve(problem, Bounds(*problem.bounds()).clip(start), options, log)
            with _keeping(ended.end):
                at = _simulation(problem, ended.at, ended.end is not End.INTERRUPTED)
            if ended.end in (End.CONVERGED, End.INTERRUPTED):
                return Solution(at, ended.at.factor, (*ended.cost[:-1], at.cost), ended.end, direct=False)
            initial, cost, direct = at, ended.cost[:-1], False
        except NumericsError:
            pass
    left = replace(options, max_iterations=max(1, options.max_iterations - len(cost)))
    further = start if initial is None else initial.unknowns
    rest = least_squares.solve(problem, further, left, initial=initial, log=_continued(log, len(cost)))
    return replace(rest, cost=(*cost, *rest.cost), direct=direct)


@contextmanager
def _keeping(end: End) -> Iterator[None]:
    """Around what makes a result of the last iterate. Of an interrupted iteration this must not take long; where it
    does, or the iterate cannot be simulated, Interrupted ends the program."""
    if end is not End.INTERRUPTED:
        yield
        return
    try:
        with winding_up():
            yield
    except NumericsError:
        raise Interrupted from None


def fits_in_memory(problem: OutputError) -> bool:
    """Whether the derivatives of all nodes are few enough to keep; else every iterate is simulated."""
    width = len(problem.columns) + len(problem.free_states)
    return problem.joint.nx * width * sum(map(len, problem.records)) <= MAX_DERIVATIVES


def _solve(problem: OutputError, start: Array, options: SolveOptions, log: Callable[[Iteration], None] | None) -> Ended:
    factor = coarse_factor(problem)
    if factor > 1:
        found = _coarse(coarsened(problem, factor), start, options, log, lambda at: _full_cost(problem, at, factor))
        if found is not None:
            start = Bounds(*problem.bounds()).clip(found.at.unknowns)
            nodes = [refined(x, factor, len(r)) for x, r in zip(found.at.nodes, problem.records, strict=True)]
            if found.end is End.INTERRUPTED:
                with _keeping(found.end):
                    return replace(found, at=iterate(problem, start, nodes))
            ended = run(
                problem, iterate(problem, start, nodes), options, _continued(log, len(found.cost) - 1), near=True
            )
            return replace(ended, cost=(*found.cost[:-1], *ended.cost))
    return run(problem, iterate(problem, start, _first_nodes(problem, start)), options, log)


def _continued(log: Callable[[Iteration], None] | None, before: int) -> Callable[[Iteration], None] | None:
    """A log whose iterations are counted on from those before."""
    return None if log is None else lambda one: log(replace(one, number=one.number + before))


def _full_cost(problem: OutputError, at: Iterate, factor: int) -> float:
    """What the motion of a coarse iterate costs on all samples, straight between its nodes."""
    cost = 0.0
    for k, (part, record) in enumerate(zip(at.parts, problem.records, strict=True)):
        t = part.trajectory
        x = refined(t.x + part.correction_of_nodes, factor, len(record))
        torque = acting_torque(t.joint, t.theta, record)
        nodes = Problem(t.joint, t.theta, torque.mean[:-1], record.sampling_time, x, begin=t.begin)
        residual = problem.residual(k, trajectory_of(nodes, torque, record, x))
        cost += 0.5 * float(residual @ residual)
    return cost


def _coarse(
    problem: OutputError,
    start: Array,
    options: SolveOptions,
    log: Callable[[Iteration], None] | None,
    measure: Callable[[Iterate], float],
) -> Ended | None:
    """Where a coarse problem ends, None where it leads nowhere. measure : the cost that is reported of its iterates."""
    samples = sum(map(len, problem.records))
    rough = replace(options, tolerance=max(options.tolerance, NOISE_SHARE * len(start) / samples))
    try:
        ended = run(problem, iterate(problem, start, _first_nodes(problem, start)), rough, log, measure=measure)
    except NumericsError:
        return None
    return ended if len(ended.cost) > 1 or ended.end is End.INTERRUPTED else None


def _first_nodes(problem: OutputError, unknowns: Array) -> list[Array]:
    """The measured motion, all other states as it drives them, one (nx, n) a record."""
    found = []
    for k, record in enumerate(problem.records):
        joint = problem.joint.along(record)
        theta = joint.in_record(problem.theta(unknowns), record.name)
        first = problem.first_state(unknowns, k)
        x = measured_guess(joint, theta, record)
        x[:, 0] = first
        torque, h = acting_torque(joint, theta, record), record.sampling_time
        nodes = Problem(joint, theta, torque.mean[:-1], h, x, begin=record.begin, torque_steps=torque.steps)
        found.append(np.array(follow_motor(nodes, first)))
    return found


def run(
    problem: OutputError,
    at: Iterate,
    options: SolveOptions,
    log: Callable[[Iteration], None] | None = None,
    *,
    near: bool = False,
    measure: Callable[[Iterate], float] = attrgetter("cost"),
) -> Ended:
    """Iterate from here until a full step promises less than the tolerance and the nodes are a simulation. near : the
    nodes are close to one, so that first states may move at once; measure : the cost that is reported of an iterate."""
    descent, end = Descent(problem, at, near, measure), End.ITERATIONS
    try:
        while len(descent.cost) <= options.max_iterations:
            done = descent.ends(options)
            if done is not None:
                end = done
                break
            check()
            if descent.advance(options.tolerance) and log is not None:
                before, cost = descent.cost[-2:]
                log(Iteration(len(descent.cost) - 1, cost, before - cost))
    except NotSettling:
        end = End.STALLED
    except (Interrupted, KeyboardInterrupt):
        if not options.interruptible:
            raise
        end = End.INTERRUPTED
    return Ended(descent.at, end, tuple(descent.cost))


@dataclass(slots=True, eq=False)
class Descent:
    """Damped steps from an iterate, one after the other. near, measure : as of `run`.

    settled : the last iterate whose nodes are a simulation; rejected, small : steps in a row that were no good, and
    that gained little; settling : nodes are expected to settle by themselves.
    """

    problem: OutputError
    at: Iterate
    near: bool
    measure: Callable[[Iterate], float] = attrgetter("cost")
    cost: list[float] = field(init=False)
    settled: Iterate | None = field(init=False)
    damping: float = field(default=FIRST_DAMPING, init=False)
    growth: float = field(default=DAMPING_GROWTH, init=False)
    rejected: int = field(default=0, init=False)
    small: int = field(default=0, init=False)
    settling: bool = field(default=True, init=False)
    bounds: Bounds = field(init=False)

    def __post_init__(self) -> None:
        self.bounds = Bounds(*self.problem.bounds())
        self.cost = [self.measure(self.at)]
        self.settled = self.at if self.at.largest <= TOLERANCE else None

    def ends(self, options: SolveOptions) -> End | None:
        """How the iteration ends here, None where it goes on."""
        promised = predicted_reduction(self.at.linear, self.bounds)
        if promised < options.tolerance * self.at.cost and self.at.largest <= TOLERANCE:
            return End.CONVERGED
        if self.small >= options.max_small_steps or self.rejected > MAX_REJECTED:
            return End.STALLED
        return None

    def step(self) -> Array:
        """The damped step of the unknowns within their bounds, (m,). First states stay while the defects are large."""
        at, bounds = self.at, self.bounds
        fixed = bounds.active(at.linear)
        if not self.near and at.defect > LARGE_DEFECT * at.cost:
            fixed[len(self.problem.columns) :] = True
        whole = damped_step(at.linear, fixed, self.damping)
        return np.asarray(bounds.stepped(at.unknowns, whole) - at.unknowns)

    def advance(self, tolerance: float) -> bool:
        """Try one step; whether it was taken. A step that gains less than the tolerance is a small one."""
        trial = attempt(self.problem, self.at, self.step(), settling=self.settling)
        self.settling = trial.settling
        if trial.after is None:
            self.rejected += 1
            self.damping, self.growth = max(self.growth * self.damping, 1e-6), 2 * self.growth
            if self.at.largest > TOLERANCE:  # its cost may not be what was expected
                self.at = self.settled = _settled(self.problem, self.at, self.settled)
            return False
        self.damping, self.growth, self.rejected = next_damping(self.damping, trial.gain), DAMPING_GROWTH, 0
        self.small = self.small + 1 if self.at.merit - trial.after.merit < tolerance * self.at.merit else 0
        self.at = trial.after
        self.cost.append(self.measure(self.at))
        if self.at.largest <= TOLERANCE:
            self.settled = self.at
        return True


def _settled(problem: OutputError, at: Iterate, before: Iterate | None) -> Iterate:
    """The iterate with simulations for nodes, or the one before it whose nodes were, if that was better. Raises
    NumericsError where there is neither."""
    try:
        most = np.inf if before is None else before.cost
        there = problem.evaluate(at.unknowns, guesses=at.nodes, max_cost=most, trial=True)
        if before is None or there.cost < before.cost:
            return iterate(problem, at.unknowns, [t.x for t in there.trajectories])
    except NumericsError:
        if before is None:
            raise
    return before


def next_damping(damping: float, gain: float) -> float:
    """The damping after a step that reached this share of its predicted reduction."""
    return max(MIN_DAMPING, damping / (10 if gain > GOOD else 1 if gain > FAIR else 0.25))


@dataclass(frozen=True, slots=True)
class Trial:
    """A step that was tried. after : the iterate there, None where the step is no good; gain : share of the predicted
    reduction; settling : one correction all but makes its nodes a simulation."""

    after: Iterate | None
    gain: float
    settling: bool


def attempt(problem: OutputError, at: Iterate, step: Array, *, settling: bool) -> Trial:
    """Try a step (m,). settling : the nodes are expected to settle by themselves; else they are made simulations."""
    predicted = -float(at.gradient @ step) - 0.5 * float(np.sum((at.factor @ step) ** 2)) + at.merit - at.cost
    unknowns = at.unknowns + step
    moved = advanced_nodes(problem, at, step)
    if settling:
        try:
            after = iterate(problem, unknowns, moved)
        except NumericsError:
            return Trial(None, -np.inf, True)
        gain = (at.merit - after.merit) / max(predicted, 1e-300)
        if gain > POOR:
            return Trial(after, gain, True)
        if after.defect < UNSETTLED * at.merit:
            return Trial(None, gain, True)
    try:
        there = problem.evaluate(unknowns, guesses=moved, max_cost=at.merit, trial=True)
    except NumericsError:
        return Trial(None, -np.inf, False)
    gain = (at.merit - there.cost) / max(predicted, 1e-300)
    if gain <= POOR or len(there.residuals) < len(problem.records):
        return Trial(None, gain, False)
    if any(t.fallback_windows for t in there.trajectories):
        raise NotSettling("a stretch of the simulation had to be integrated step by step")
    try:
        after = iterate(problem, unknowns, [t.x for t in there.trajectories])
    except NumericsError:
        return Trial(None, -np.inf, False)
    return Trial(after, gain, _defect(problem, moved, there) < UNSETTLED * at.merit)


def _defect(problem: OutputError, nodes: Sequence[Array], at: Evaluation) -> float:
    """Half the square sum of what the output of nodes (nx, n) differs from that of a simulation."""
    total = 0.0
    for k, (x, t) in enumerate(zip(nodes, at.trajectories, strict=True)):
        row = problem.row
        difference = problem.shaped(k, x[row] - t.x[row])
        total += 0.5 * float(difference @ difference)
    return total


def _simulation(problem: OutputError, at: Iterate, trial: bool) -> Evaluation:
    """The iterate with its trajectories as simulations: corrected once more where they all but are, else integrated.
    trial : as of `OutputError.evaluate`."""
    if at.largest > TOLERANCE:
        return problem.evaluate(at.unknowns, guesses=at.nodes, trial=trial)
    trajectories, residuals = [], []
    for k, part in enumerate(at.parts):
        t, record = part.trajectory, problem.records[k]
        x = t.x + part.correction_of_nodes
        nodes = Problem(t.joint, t.theta, t.u[:-1], t.sampling_time, x, begin=t.begin)
        trajectory = trajectory_of(nodes, ActingTorque(t.u, t.torque_steps), record, x)
        trajectories.append(trajectory)
        residuals.append(problem.residual(k, trajectory))
    return Evaluation(at.unknowns, tuple(residuals), tuple(trajectories))
