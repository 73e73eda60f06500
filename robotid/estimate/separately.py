"""Many small problems of one model, each solved by itself, their simulations and derivatives found at once.

Pieces of a record that share nothing but their parameters are fitted each to its own first states. Each iteration goes
as `least_squares.solve` does; what all of them ask next is answered in one simulation, whose cost hardly grows with the
number of pieces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.least_squares import (
    Point,
    Question,
    Solution,
    SolveOptions,
    answer,
    linearise,
    solving,
)
from robotid.estimate.residual import Evaluation, Linearisation, OutputError
from robotid.simulation.courses import driven
from robotid.simulation.simulate import simulate_together

Answer = Evaluation | Linearisation | NumericsError


def solve_separately(
    problems: Sequence[OutputError], starts: Sequence[np.ndarray], options: SolveOptions
) -> list[Solution]:
    """The solution of each problem, of one record each, from its start (m,).

    problems : of one joint with the same parameters, all of them fixed. Raises NumericsError where one of them cannot
    be simulated.
    """
    courses = [solving(one, start, options) for one, start in zip(problems, starts, strict=True)]

    def answers(asked: Mapping[int, Question]) -> dict[int, Answer]:
        points = {k: question for k, question in asked.items() if isinstance(question, Point)}
        ends = {k: question for k, question in asked.items() if isinstance(question, Evaluation)}
        return {**_evaluated(problems, points), **_linearised(problems, ends)}

    return driven(courses, answers)


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
