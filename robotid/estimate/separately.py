"""Many small problems of one model, each solved by itself, their simulations and derivatives found at once.

Pieces of a record that share nothing but their parameters are fitted each to its own first states. Each iteration goes
as `least_squares.solve` does; what all of them ask next is answered in one simulation, whose cost hardly grows with the
number of pieces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.least_squares import (
    Course,
    Point,
    Question,
    Solution,
    SolveOptions,
    answer,
    linearise,
    solving,
)
from robotid.estimate.residual import Evaluation, Linearisation, OutputError
from robotid.estimate.result import End
from robotid.interrupt import INTERRUPTS
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulation.courses import driven
from robotid.simulation.simulate import simulate_together

FIRST_STATES = SolveOptions(max_iterations=8, tolerance=1e-4)  # the first states of a record need no more
STANDS_OUT = 2.0  # times the usual mean square of pieces: one that leaves more may be on the wrong side of a play
WORTH_IT = 0.01  # of the cost, which better first states of pieces must save for the parameters to be sought again

Answer = Evaluation | Linearisation | NumericsError

Start = Array | Evaluation
"""Unknowns (m,) from which a problem is solved, or its evaluation there."""


def solve_separately(problems: Sequence[OutputError], starts: Sequence[Start], options: SolveOptions) -> list[Solution]:
    """The solution of each problem, of one record each, from its start.

    problems : of one joint with the same parameters, all of them fixed. Raises NumericsError where one of them cannot
    be simulated.
    """
    courses = [_course(one, start, options) for one, start in zip(problems, starts, strict=True)]

    def answers(asked: Mapping[int, Question]) -> dict[int, Answer]:
        points = {k: question for k, question in asked.items() if isinstance(question, Point)}
        ends = {k: question for k, question in asked.items() if isinstance(question, Evaluation)}
        return {**_evaluated(problems, points), **_linearised(problems, ends)}

    return driven(courses, answers)


def _course(problem: OutputError, start: Start, options: SolveOptions) -> Course[Solution]:
    if isinstance(start, Evaluation):
        return solving(problem, start.unknowns, options, initial=start)
    return solving(problem, start, options)


def solve_in_a_row(problems: Sequence[OutputError], starts: Sequence[Start], options: SolveOptions) -> list[Solution]:
    """The same, where a piece that follows another of its record is solved from where that one ends, too: behind a gear
    with play the first samples do not show on which side it is, and no step leads across. The better solution counts.
    """
    return _continued(problems, solve_separately(problems, starts, options), options)


Solver = Callable[[Evaluation | None], Solution]
"""What finds the solution of a problem from an evaluation, None from where the problem starts by itself."""


def solve_by_pieces(
    problem: OutputError, start: Evaluation | None, solver: Solver, *, interruptible: bool = False
) -> Solution:
    """The solution of a problem from an evaluation of all its records, where there is one. That of pieces in a row
    begins at the first states that suit each best, and is sought again as long as there are better ones.
    interruptible : as of `SolveOptions`."""
    if not in_a_row(problem):
        return solver(start)
    found = solver(None if start is None else _with_better_first_states(problem, start))
    while found.end is not End.INTERRUPTED:
        try:
            better = _with_better_first_states(problem, found.evaluation)
        except INTERRUPTS:
            if not interruptible:
                raise
            return replace(found, end=End.INTERRUPTED)
        if better.cost >= (1.0 - WORTH_IT) * found.evaluation.cost:
            break
        further = solver(better)
        found = replace(further, cost=(*found.cost, *further.cost))
    return found


def in_a_row(problem: OutputError) -> bool:
    """Whether some records of a problem are pieces of one in a row, with first states that are to be found."""
    return bool(problem.free_states) and any(map(Record.follows, problem.records[1:], problem.records))


def _with_better_first_states(problem: OutputError, at: Evaluation) -> Evaluation:
    """An evaluation with the first states that suit each piece best, where the one before it ends among those from
    which they are sought; the parameters as they are."""
    parameters = problem.parameters.with_values(problem.theta(at.unknowns)).all_fixed
    alone = [_of_one(replace(problem, parameters=parameters), k) for k in range(len(problem.records))]
    own = at.unknowns[len(problem.columns) :].reshape(len(alone), -1)
    parts = zip(own, at.residuals, at.trajectories, strict=True)
    known = [Solution(Evaluation(x0, (r,), (t,)), np.empty((0, 0)), (), End.CONVERGED) for x0, r, t in parts]
    found = [one.evaluation for one in _continued(alone, known, FIRST_STATES)]
    unknowns = np.concatenate([at.unknowns[: len(problem.columns)], *(one.unknowns for one in found)])
    return Evaluation(unknowns, tuple(e.residuals[0] for e in found), tuple(e.trajectories[0] for e in found))


def _of_one(problem: OutputError, k: int) -> OutputError:
    """A problem on its record k alone."""
    part = slice(k, k + 1)
    return replace(problem, records=problem.records[part], weights=problem.weights[part], whiten=problem.whiten[part])


def _continued(problems: Sequence[OutputError], solutions: Sequence[Solution], options: SolveOptions) -> list[Solution]:
    """Solutions, that of a piece which follows another one replaced by what is found from there where that is better,
    until none is."""
    found, records = list(solutions), [one.records[0] for one in problems]
    following = [k for k in range(1, len(records)) if records[k].follows(records[k - 1])]
    after = following
    while after:
        usual = np.median([_mean_square(one.evaluation) for one in found])
        starts = _starts_in_a_row(problems, found, after)
        worth = {
            k: start
            for k, start in starts.items()
            if start.cost < _cost(found[k]) or _mean_square(found[k].evaluation) > STANDS_OUT * usual
        }
        try:
            others = solve_separately([problems[k] for k in worth], [*worth.values()], options)
        except NumericsError:
            break
        better = {k: one for k, one in zip(worth, others, strict=True) if _cost(one) < _cost(found[k])}
        gained = [k for k, one in better.items() if _cost(one) < (1.0 - options.tolerance) * _cost(found[k])]
        for k, one in better.items():
            found[k] = one
        after = [k for k in following if k - 1 in gained]
    return found


def _starts_in_a_row(
    problems: Sequence[OutputError], found: Sequence[Solution], after: Sequence[int]
) -> dict[int, Evaluation]:
    """Pieces as they begin where the ones before them end, those that can be simulated from there."""
    points = {k: Point(_end_as_start(found[k - 1].evaluation, problems[k])) for k in after}
    return {k: one for k, one in _evaluated(problems, points).items() if isinstance(one, Evaluation)}


def _end_as_start(before: Evaluation, problem: OutputError) -> Array:
    """Unknowns (m,) of a piece that begins where the one before it ends."""
    lower, upper = problem.bounds()
    return np.clip(before.trajectories[0].x[list(problem.free_states), -1], lower, upper)


def _mean_square(one: Evaluation) -> float:
    """Half that of the residual of one record."""
    return one.cost / len(one.residuals[0])


def _cost(solution: Solution) -> float:
    return solution.evaluation.cost


def _evaluated(problems: Sequence[OutputError], points: Mapping[int, Point]) -> dict[int, Answer]:
    """Evaluations of the problems at these points, all at once where none of them fails."""
    if len(points) > 1:
        first = problems[next(iter(points))]
        starts = [problems[k].start_of(0, one.unknowns, one.near) for k, one in points.items()]
        records = [problems[k].records[0] for k in points]
        try:
            courses = simulate_together(first.joint, first.parameters.values, records, starts)
            return {
                k: Evaluation(points[k].unknowns, (problems[k].residual(0, trajectory),), (trajectory,))
                for k, trajectory in zip(points, courses, strict=True)
            }
        except NumericsError:
            pass
    return {k: _answer(problems[k], one) for k, one in points.items()}


@np.errstate(all="ignore")  # derivatives that are not finite are reported
def _linearised(problems: Sequence[OutputError], ends: Mapping[int, Evaluation]) -> dict[int, Answer]:
    """Linearisations of the problems there."""
    if not ends:
        return {}
    steps = problems[next(iter(ends))].steps_of([one.trajectories[0] for one in ends.values()])
    found: dict[int, Answer] = {}
    for (k, one), own in zip(ends.items(), steps, strict=True):
        try:
            found[k] = linearise(problems[k], one, [own])
        except NumericsError as error:
            found[k] = error
    return found


def _answer(problem: OutputError, question: Question) -> Answer:
    try:
        return answer(problem, question)
    except NumericsError as error:
        return error
