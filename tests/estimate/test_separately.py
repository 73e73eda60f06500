"""Pieces of a record fitted all at once end as each does alone."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_bench import fitted, records

from robotid.errors import NumericsError
from robotid.estimate import separately
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.least_squares import SolveOptions, solve
from robotid.estimate.residual import OutputError
from robotid.estimate.separately import solve_separately

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
