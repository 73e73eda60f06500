"""Detection limits: an effect as large as its limit has the energy of a cause, and what has no column has no limit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import isinf

import numpy as np
import pytest
from support.noise import speed_whitening
from support.small_bench import AXIS, fitted, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.scoring.limits import detection_limits, least_energy
from robotid.diagnosis.scoring.ranking import Round, rank, scan_candidates
from robotid.estimate.fitted_model import fitted_model

SPEED, TORQUE = 0.02, 0.02
CRITERIA = Criteria(skip=("record_change",))


@cache
def seen() -> Round:
    """The axis on records that it made itself, with the noise of the small bench."""
    made = list(records({}))
    fit = fitted_model(fitted(made))
    levels = (SPEED**2, TORQUE**2)
    segments = tuple(Segment(r, speed_whitening(fit.joint, fit.theta, r.sampling_time, levels)) for r in made[:2])
    data = EvaluationData(segments, (), "speed", estimate_states=True, noise_reached=True, torque_errors=False)
    return rank(scan_candidates(refit(AXIS, [fit.parameters], data), CRITERIA.skip), CRITERIA)


def test_an_effect_as_large_as_its_limit_explains_what_a_cause_must() -> None:
    limits = {one.effect: one for one in detection_limits(seen(), CRITERIA)}
    names = [one.name for one in seen().candidates]
    k = names.index("motor.quadratic_friction")
    column = seen().projected.missing[:, sum(len(one.scored) for one in seen().candidates[:k])]
    energy = limits["motor.quadratic_friction"].size ** 2 * float(column @ column)
    tries, samples = len(seen().scores), seen().model.samples
    assert energy == pytest.approx(least_energy(1, seen().inflation, CRITERIA, tries, samples))
    assert (limits["motor.quadratic_friction"].symbol, limits["motor.quadratic_friction"].unit) == (
        "Fq",
        "Nm s2/rad2",
    )


def test_every_effect_of_the_catalogue_that_the_model_lacks_has_one_limit() -> None:
    found = detection_limits(seen(), CRITERIA)
    assert [one.effect for one in found] == sorted({one.name for one in seen().candidates})
    lacking = detection_limits(seen(), CRITERIA, present=("motor.stribeck",))
    assert {one.effect for one in found} - {one.effect for one in lacking} == {"motor.stribeck"}


def test_what_the_fitted_parameters_do_as_well_is_invisible() -> None:
    """The gain of the torque is that of all parameters together."""
    limits = {one.effect: one.size for one in detection_limits(seen(), CRITERIA)}
    assert isinf(limits["torque.torque_gain"])
    assert not isinf(limits["motor.stribeck"])


def test_twice_the_noise_makes_the_limits_twice_as_large() -> None:
    loud = replace(seen(), inflation=4.0 * seen().inflation)
    anything = replace(CRITERIA, min_improvement_sigma=0.0)
    pairs = zip(detection_limits(seen(), anything), detection_limits(loud, anything), strict=True)
    ratios = [after.size / before.size for before, after in pairs if not isinf(before.size) and not isinf(after.size)]
    assert len(ratios) > 5
    assert np.allclose(ratios, 2.0)
