"""Pieces of a record fitted all at once end as each does alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH, multisine
from support.small_bench import fitted, records

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate import separately
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.least_squares import Solution, SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.result import End
from robotid.estimate.separately import solve_by_pieces, solve_in_a_row, solve_separately
from robotid.interrupt import Interrupted
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

NOISE = 0.02  # of the speed [rad/s]
OPTIONS = SolveOptions(max_iterations=8, tolerance=1e-4)


def problems() -> list[OutputError]:
    """The first states of the pieces of two records."""
    made = records({})
    model = fitted_model(fitted(list(made)))
    pieces = [piece for record in made[:2] for piece in record.pieces(record.duration / 4)]
    return [OutputError(model.joint, model.parameters.all_fixed, (piece,), "speed", np.ones(1)) for piece in pieces]


def test_pieces_at_once_end_as_each_alone() -> None:
    every = problems()
    found = solve_separately(every, [one.start() for one in every], OPTIONS)
    for problem, solution in zip(every, found, strict=True):
        alone = solve(problem, problem.start(), OPTIONS)
        assert solution.end is alone.end
        assert solution.evaluation.cost == pytest.approx(alone.evaluation.cost, rel=1e-6)


def test_one_simulation_that_fails_does_not_spoil_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise NumericsError("one of them diverges")

    every = problems()[:2]
    expected = [one.evaluation.cost for one in solve_separately(every, [one.start() for one in every], OPTIONS)]
    monkeypatch.setattr(separately, "simulate_together", fail)
    found = solve_separately(every, [one.start() for one in every], OPTIONS)
    assert [one.evaluation.cost for one in found] == pytest.approx(expected, rel=1e-6)


@cache
def behind_a_play() -> tuple[Joint, Parameters, Record]:
    """A joint whose gear has play, its true parameters, and a record of it."""
    joint = assemble(STRUCTURE.extended("gear.backlash"), angle=True)
    parameters = joint.parameters().with_values(TRUTH | {"gear.backlash.gap": 3e-4})
    t = np.arange(3000) * SAMPLING_TIME
    plant = VirtualRobot(joint, parameters.values, Controller("speed", 0.5, 5.0), 0.0, 0.0, NOISE, seed=1)
    return joint, parameters, plant.record(Reference("set2", SAMPLING_TIME, multisine(t, 5.0) + 8.0, "speed"), 0)


def test_a_piece_on_the_wrong_side_of_the_play_begins_where_the_one_before_it_ends() -> None:
    joint, parameters, record = behind_a_play()
    pieces = record.pieces(0.1)
    every = [OutputError(joint, parameters.all_fixed, (piece,), "speed", np.ones(1)) for piece in pieces]
    starts = [one.start() for one in every]
    alone, in_a_row = (
        [np.sqrt(2.0 * one.evaluation.cost / len(piece)) for one, piece in zip(found, pieces, strict=True)]
        for found in (solve_separately(every, starts, OPTIONS), solve_in_a_row(every, starts, OPTIONS))
    )
    assert max(alone) > 10.0 * NOISE  # the first samples of one piece do not show the side
    assert max(in_a_row) < 1.2 * NOISE


def test_a_fit_of_pieces_behind_a_play_reaches_the_noise() -> None:
    joint, parameters, record = behind_a_play()
    start = parameters.with_values({"motor.inertia.J": 1.01 * TRUTH["motor.inertia.J"], "gear.backlash.gap": 2.9e-4})
    found = fit_model("m", joint, start, [record], FitOptions(horizon=0.1))
    assert found.noise_std["set2"] < 1.1 * NOISE
    gap = next(one for one in found.parameters if one.name == "gear.backlash.gap")
    assert abs(gap.value - 3e-4) < 4.0 * gap.std


def test_records_that_are_no_pieces_are_solved_once() -> None:
    asked = list[Evaluation | None]()
    made = records({})
    model = fitted_model(fitted(list(made)))
    problem = OutputError(model.joint, model.parameters, tuple(made[:2]), "speed", np.ones(2))

    def solver(at: Evaluation | None) -> Solution:
        asked.append(at)
        return solve(problem, problem.start(), OPTIONS, initial=at)

    begun = problem.evaluate(problem.start())
    solve_by_pieces(problem, begun, solver)
    assert asked == [begun]


@pytest.mark.parametrize("interruptible", [True, False])
def test_an_interrupt_among_the_first_states_keeps_the_last_solution(
    monkeypatch: pytest.MonkeyPatch, interruptible: bool
) -> None:
    joint, parameters, record = behind_a_play()
    pieces = record.pieces(0.1)[:2]
    problem = OutputError(joint, parameters, pieces, "speed", np.ones(2))
    found = Solution(problem.evaluate(problem.start()), np.eye(1), (), End.CONVERGED)

    def interrupt(*_: object) -> None:
        raise Interrupted

    monkeypatch.setattr(separately, "solve_separately", interrupt)
    if interruptible:
        assert solve_by_pieces(problem, None, lambda _: found, interruptible=True).end is End.INTERRUPTED
    else:
        with pytest.raises(Interrupted):
            solve_by_pieces(problem, None, lambda _: found)
