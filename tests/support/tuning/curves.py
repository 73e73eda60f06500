"""Checks of the constants of free curves."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from robotid.diagnosis.misfit.curve import BY_TORQUE
from robotid.diagnosis.nonparametric import curve_fit, curve_term
from robotid.diagnosis.nonparametric.basis import Variable, _knots, at_measured_speed, variables
from robotid.diagnosis.nonparametric.curve_fit import (
    FittedCurve,
    _confounded,
    coarse_knots,
    fit_acting,
    fit_curves,
    free_forces,
)
from robotid.diagnosis.nonparametric.curve_term import FreeCurve
from robotid.diagnosis.nonparametric.settings import CURVES
from robotid.diagnosis.refit.refitted_model import RefittedModel
from support.plain_models import plain_data, plain_model, plain_segment
from support.tuning import sees

TIME = Variable("t", "s")


@sees(CURVES, "edge_percent")
def check_half_a_per_cent_lies_beyond_each_end() -> None:
    knots = _knots(np.linspace(0.0, 100.0, 1001), TIME, 12)
    assert (knots[0], knots[-1]) == pytest.approx((0.5, 99.5))


@sees(CURVES, "coarse_knots")
def check_a_coarse_curve_has_a_dozen_knots() -> None:
    segment = plain_segment(1.0)
    motion = at_measured_speed(segment.trajectory, segment.record)
    found = variables(motion)
    flat = [one for one in found if not one.turn]
    assert {coarse_knots(one) for one in flat} == {12}
    assert free_forces(segment).shape[1] == 12 * len(flat) + 48 * (len(found) - len(flat)) > 0


@sees(CURVES, "fine_knots")
def check_what_repeats_in_a_turn_is_compared_as_finely_as_any() -> None:
    assert coarse_knots(Variable("phi_m mod 2 pi", "rad", BY_TORQUE, turn=True)) == 48


def asked_along() -> list[tuple[int, list[int]]]:
    """How many variables are fitted with which numbers of knots, in turn."""
    asked = list[tuple[int, list[int]]]()

    def along(motions: Any, model: Any, data: Any, chosen: list[Any], counts: Any = ()) -> list[Any]:
        asked.append((len(chosen), list(counts)))
        return [SimpleNamespace(variable=TIME) for _ in range(7)]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curve_fit, "_along", along)
        fit_curves(plain_model(2000.0), plain_data())
    return asked


@sees(CURVES, "fine_knots")
def check_a_fine_curve_has_twice_or_four_times_as_many_as_a_coarse_one() -> None:
    assert asked_along()[1][1] == [24, 48]


@sees(CURVES, "finalists")
def check_two_variables_are_fitted_finely() -> None:
    assert asked_along()[1][0] == 2


@sees(CURVES, "faded_share")
def check_of_a_curve_that_the_fit_took_three_per_cent_may_be_left() -> None:
    def confounded(left: float) -> int:
        return len(_confounded(np.diag([1.0, np.sqrt(left)]), np.eye(2)))

    assert confounded(0.027) == 1
    assert confounded(0.033) == 0


@sees(CURVES, "ridge")
def check_a_curve_that_no_motion_shows_counts_as_taken() -> None:
    def confounded(energy: float) -> int:
        columns = np.diag([1.0, np.sqrt(energy)])
        return len(_confounded(columns, columns))

    # three per cent of it are left where its energy is three per cent of the ridge
    assert confounded(0.025e-9) == 1
    assert confounded(0.04e-9) == 0


def sweeps(*energies: float) -> int:
    """How often a curve is refitted whose refits leave these energies."""
    left, count = iter(energies), 0

    def refitted(*_: Any) -> RefittedModel:
        nonlocal count
        count += 1
        return plain_model(next(left))

    basis: Any = SimpleNamespace(variable=TIME, knots=np.linspace(0.0, 1.0, 4))
    curve = FittedCurve(basis, None, 0.0, np.zeros(4), np.zeros(3))  # type: ignore[arg-type]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curve_fit, "refit_with_curve", refitted)
        patch.setattr(curve_fit, "basis_at", lambda *_: basis)
        patch.setattr(curve_fit, "_fit", lambda *_: [curve])
        fit_acting(curve, plain_model(10_000.0), plain_data())
    return count


@sees(CURVES, "max_sweeps")
def check_a_curve_acts_in_four_sweeps() -> None:
    assert sweeps(*np.linspace(9000.0, 1000.0, 20)) == 4


@sees(CURVES, "settled_gain")
def check_a_sweep_that_gains_a_thousandth_is_the_last() -> None:
    explained = 8000.0
    assert sweeps(2000.0, 2000.0 - 0.8e-3 * explained, 1000.0, 500.0) == 2
    assert sweeps(2000.0, 2000.0 - 1.2e-3 * explained, 1000.0, 500.0) == 4


@sees(CURVES, "likely_torque")
def check_a_missing_torque_is_likely_half_as_large_as_the_recorded_one() -> None:
    sizes = list[float]()
    data = plain_data()
    record = replace(data.fitted[0].record, tau_m=np.full(1000, -4.0))
    data = replace(data, fitted=(replace(data.fitted[0], record=record),))
    basis: Any = SimpleNamespace(forces=(np.zeros((1, 4, 1000)),), knots=np.zeros(4))

    def curve(projected: Any, at: slice, basis: Any, torque: float, acting: Any) -> Any:
        sizes.append(torque)
        return SimpleNamespace(energy=0.0)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curve_fit, "project", lambda _: SimpleNamespace(whole=np.ones((1, 4))))
        patch.setattr(curve_fit, "_curve", curve)
        curve_fit._fit(plain_model(2000.0), data, [basis])
    assert sizes == pytest.approx([2.0])


def refit_options() -> Any:
    """How a model is refitted with a curve."""
    asked = list[Any]()
    curve = FreeCurve(TIME, np.linspace(0.0, 1.0, 4), np.zeros(4))
    near = plain_model(2000.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curve_term, "refit", lambda *arguments: asked.append(arguments[-1]))
        curve_term.refit_with_curve(near.joint, near, plain_data(), curve, np.zeros(3))
    return asked[0]


@sees(CURVES, "patience")
def check_a_curve_with_many_windows_that_fail_is_no_torque() -> None:
    assert 3 <= refit_options().patience <= 6  # fewer than any effect of the catalogue may have


@sees(CURVES, "max_iterations")
def check_a_sweep_takes_four_iterations() -> None:
    assert 3 <= refit_options().max_iterations <= 6  # the next sweep goes on
