"""An effect that is not named yet makes noise of its own, and must be larger by that to score."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import isinf

import numpy as np
import pytest
from support.small_bench import begun, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.noise_estimate import sensor_noise
from robotid.diagnosis.scoring.candidate import columns_of
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.projection import Projected, project
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.diagnosis.search.least_scored import least_scored, residuals_with
from robotid.diagnosis.search.state import SearchState

CRITERIA = Criteria(skip=("record_change",))
ENERGY = 60.0


@cache
def clean() -> SearchState:
    """Of the small bench with nothing hidden."""
    return begun(records({}), CRITERIA)


@cache
def through(effect: str) -> tuple[tuple[Scan, ...], Projected, slice]:
    """The columns of an effect of few parameters through the clean model, and where they are."""
    state = clean()
    one = next(one for one in candidates(state.model.structure, "speed") if one.name == effect)
    seen = scans(state.model.fitted, state.model.unknowns, [one])
    seen = tuple(s.whitened_as(segment) for s, segment in zip(seen, state.data.fitted, strict=True))
    return seen, project(seen), next(columns_of([one]))


def test_what_an_effect_adds_lies_along_nothing_that_the_fit_has_shaped() -> None:
    seen, projected, at = through("motor.quadratic_friction")
    hidden = residuals_with(seen, projected, at, np.array([1e-4]))
    states, fitted, added = [], [], []
    for one, with_effect in zip(seen, hidden, strict=True):
        white = one.whitening(np.concatenate([one.signals, with_effect.residual[None]]))
        added.append(white[-1] - white[-2])
        states.append(white[: one.states] @ added[-1] / np.linalg.norm(white[: one.states], axis=1))
        fitted.append(white[one.states : one.known])
    length = np.linalg.norm(np.concatenate(added))
    along = np.hstack(fitted) @ np.concatenate(added) / np.linalg.norm(np.hstack(fitted), axis=1)
    assert length > 1.0
    assert np.abs(states).max() < 1e-6 * length
    assert np.abs(along).max() < 1e-6 * length


def test_the_noise_beside_an_effect_is_that_of_records_in_which_it_is_hidden() -> None:
    size = 1e-4
    seen, projected, at = through("motor.quadratic_friction")
    expected = sensor_noise(residuals_with(seen, projected, at, np.array([size])), "speed")
    hidden = begun(records({"motor.quadratic_friction.Fq": size}), CRITERIA).data.fitted
    levels, without = hidden[0].whitening.levels, clean().data.fitted[0].whitening.levels
    assert levels.torque > 3.0 * without.torque
    assert expected[0].whitening.levels.torque == pytest.approx(levels.torque, rel=0.1)
    assert expected[0].whitening.levels.output == pytest.approx(levels.output, rel=0.01)


def test_an_effect_that_is_taken_for_noise_of_the_torque_must_be_larger_to_score() -> None:
    seen, projected, at = through("motor.quadratic_friction")
    plain = np.sqrt(ENERGY) / projected.visible_length(at)
    size = least_scored(seen, projected, at, ENERGY, clean().data)
    assert 1.02 * plain < size < 3.0 * plain


def test_noise_that_cannot_matter_is_not_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    """At most it doubles the size: beyond twice of it, what is asked for anyway decides."""
    seen, projected, at = through("motor.quadratic_friction")
    plain = np.sqrt(ENERGY) / projected.visible_length(at)
    size = least_scored(seen, projected, at, ENERGY, clean().data)
    assert least_scored(seen, projected, at, ENERGY, clean().data, 1.9 * plain) == size
    monkeypatch.setattr("robotid.diagnosis.search.least_scored.sensor_noise", None)
    assert least_scored(seen, projected, at, ENERGY, clean().data, 2.0 * plain) <= 2.0 * plain


def test_where_errors_of_the_torque_are_allowed_for_an_effect_is_no_part_of_them() -> None:
    seen, projected, at = through("motor.quadratic_friction")
    blunt = replace(clean().data, torque_errors="white")
    assert least_scored(seen, projected, at, ENERGY, blunt) == np.sqrt(ENERGY) / projected.visible_length(at)


def test_what_the_fitted_parameters_do_as_well_never_scores() -> None:
    seen, projected, at = through("torque.torque_gain")
    assert isinf(least_scored(seen, projected, at, ENERGY, clean().data))
