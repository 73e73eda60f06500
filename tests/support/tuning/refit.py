"""Checks of the constants of refits."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.refit import refit as refits
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.multiple_shooting import _cut
from robotid.diagnosis.refit.refit import CAREFUL, QUICK, RefitOptions, solve_effort
from robotid.diagnosis.refit.settings import REFIT
from robotid.errors import NumericsError
from support.plain_models import plain_data, plain_model, plain_record
from support.small_bench import records
from support.tuning import sees

SAMPLES = 10_000


@sees(REFIT, "unidentifiable")
def check_what_is_a_billionth_of_the_information_is_none() -> None:
    def std(apart: float) -> float:
        return float(plain_model(1000.0, factor=np.array([[1.0, 1.0], [0.0, apart]])).covariance[0, 0])

    # the singular values of two columns at a small angle are its half, times the root of two, and the root of two
    assert std(1.5 * 2e-9) > 1e10
    assert std(0.7 * 2e-9) < 1e10


@sees(REFIT, "patience")
def check_eight_windows_may_fail_but_any_number_for_the_model_that_is_diagnosed() -> None:
    problem = refits._problem(assemble(AXIS := plain_model(1.0).structure), assemble(AXIS).parameters(), (), DATA, None)
    assert problem.max_failed_windows is None
    assert CAREFUL.max_failed_windows is None
    assert RefitOptions(patience=4).max_failed_windows == RefitOptions(careful=True, patience=4).max_failed_windows == 4
    assert 5 <= (QUICK.max_failed_windows or 0) <= 10  # a model near its best has three at most


DATA = plain_data()


@sees(REFIT, "max_iterations")
def check_a_refit_takes_a_dozen_iterations() -> None:
    assert 8 <= solve_effort(SAMPLES, SAMPLES, QUICK).max_iterations <= 16  # one that is on its way needs half of them
    assert solve_effort(SAMPLES, SAMPLES, RefitOptions(max_iterations=4)).max_iterations == 4


@sees(REFIT, "further_iterations")
@sees(REFIT, "steady")
def check_in_a_narrow_valley_a_refit_goes_on_while_each_iteration_gets_on() -> None:
    effort = solve_effort(SAMPLES, SAMPLES, QUICK)
    slow, slower, first = (0.9 ** np.arange(n) for n in (30, 60, 12))
    assert effort.goes_on(slow)
    assert not effort.goes_on(slower)
    assert effort.goes_on(0.96 ** np.arange(30))
    assert not effort.goes_on(0.98 ** np.arange(30))
    assert effort.goes_on(first**0.0)
    assert not solve_effort(SAMPLES, SAMPLES, RefitOptions(max_iterations=4)).goes_on(slow[:5])


@sees(REFIT, "tolerance")
def check_a_step_that_gains_less_than_one_variance_in_ten_thousand_samples_is_the_last() -> None:
    assert solve_effort(SAMPLES, SAMPLES, QUICK).tolerance * SAMPLES == pytest.approx(1.0, rel=0.5)


@sees(REFIT, "careful_tolerance")
def check_the_diagnosed_model_is_refitted_to_a_tenth_of_that() -> None:
    assert solve_effort(SAMPLES, SAMPLES, CAREFUL).tolerance * SAMPLES == pytest.approx(0.1, rel=0.5)


@sees(REFIT, "misfit_tolerance")
def check_beside_a_large_misfit_three_thousandths_are_enough() -> None:
    assert solve_effort(SAMPLES, 100.0 * SAMPLES, CAREFUL).tolerance == pytest.approx(3e-3, rel=0.2)


@sees(REFIT, "little_misfit")
def check_the_finest_steps_are_for_models_with_less_misfit_than_noise() -> None:
    def fine(misfit: float) -> bool:
        return solve_effort(SAMPLES, SAMPLES / (1.0 - misfit), CAREFUL).max_small_steps > 1

    assert fine(0.45)
    assert not fine(0.55)


@cache
def moving() -> EvaluationData:
    """Two records of a small axis, whose noise is far larger than what a model may leave."""
    segments = tuple(Segment(record, UNIT_WHITENING) for record in records({})[:2])
    return EvaluationData(segments, (), "speed", True, True, torque_errors=None)


@sees(REFIT, "hopeless_start")
def check_a_start_that_leaves_twenty_times_too_much_on_the_first_record_is_hopeless() -> None:
    joint = plain_model(1.0).joint
    start = joint.parameters()
    problem = refits._problem(joint, start, moving().fitted[:1], moving(), None)
    energy = 2.0 * refits._begin(problem, ()).cost

    def hopeless(ratio: float) -> bool:
        options = RefitOptions(start_below=energy / ratio, careful=True)
        try:
            refits._best_start(joint, [start], moving(), (), options)
        except NumericsError:
            return True
        return False

    assert not hopeless(18.0)
    assert hopeless(22.0)


def validation_effort() -> Any:
    """How a validation record is solved."""
    asked = list[Any]()

    def solve(problems: Any, starts: Any, options: Any) -> Any:
        asked.append(options)
        raise NumericsError("no")

    joint = plain_model(1.0).joint
    problem = refits._problem(joint, joint.parameters(), DATA.fitted, DATA, None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(refits, "solve_in_a_row", solve)
        with pytest.raises(NumericsError):
            refits._validate(problem, joint.parameters(), DATA, ())
    return asked[0]


@sees(REFIT, "max_validation_iterations")
def check_first_states_of_a_validation_record_take_eight_iterations() -> None:
    assert 5 <= validation_effort().max_iterations <= 12  # the problem is nearly linear in them


@sees(REFIT, "validation_tolerance")
def check_a_validation_record_is_solved_as_exactly_as_a_fitted_one() -> None:
    assert validation_effort().tolerance == pytest.approx(solve_effort(SAMPLES, SAMPLES, QUICK).tolerance, rel=0.5)


@sees(REFIT, "pieces")
def check_a_record_is_cut_into_eighths() -> None:
    pieces = _cut([Segment(plain_record(), UNIT_WHITENING)])
    assert [len(piece.record) for piece in pieces] == [125] * 8
