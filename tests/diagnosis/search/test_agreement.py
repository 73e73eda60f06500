"""Records that were held out: whether the model can be theirs, too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter
from support.small_bench import SAMPLING_TIME, TRUTH, Criteria, fitted, made_along, records, references

from robotid.diagnosis.procedure import diagnose
from robotid.diagnosis.results import Diagnosis
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression
from robotid.diagnosis.search import record_changes
from robotid.diagnosis.search.coloured import Left
from robotid.report.tables.diagnose import sentence

FEW = Criteria(max_refits=1)


@cache
def accelerated(by: float, heavier: float = 1.0, wider: float = 1.0) -> Diagnosis:
    """An axis fitted at a speed that varies by so much [rad/s], and held to a record in which that varies more, so many
    times as much as elsewhere, and the inertia is so many times as large."""
    t = np.arange(1500) * SAMPLING_TIME
    even = {f"even{k}": 6.0 - k + by * np.sin(2 * np.pi * (0.5 + 0.1 * k) * t) for k in range(2)}
    loaded = TRUTH | {"motor.inertia.J": heavier * TRUTH["motor.inertia.J"]}
    (check,) = made_along({"check": wider * references()["wide"]}, loaded)
    made = [*(one.piece(500, 1500) for one in made_along(even)), replace(check, role="validate")]
    return diagnose(fitted(made), made, FEW)


def test_a_parameter_that_the_fitted_records_leave_uncertain_has_not_changed() -> None:
    found = accelerated(by=0.2, wider=2.0)
    assert found.records["check"].misfit > 2.0 * found.records["check"].noise_floor
    assert found.verdict == "clean"
    assert not found.causes
    assert "simulates check as well once it is fitted" in found.remarks[0]


def test_one_that_has_changed_is_named() -> None:
    found = accelerated(by=2.0, heavier=1.2)
    assert [cause.effect for cause in found.causes] == ["record_change.check.motor.inertia.J"]
    assert found.causes[0].parameters[0].value == pytest.approx(0.2 * TRUTH["motor.inertia.J"], rel=0.1)


def test_one_whose_size_scatters_from_block_to_block_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[tuple[int, ...]]()
    blocks_with = record_changes.blocks_with

    def scattered(left: Left, sizes: Mapping[int, float]) -> BlockedRegression:
        """What is asked for in one half of the blocks, the other half asks for the other way round."""
        asked.append(tuple(sizes))
        found, sign = blocks_with(left, sizes), np.resize([1.0, -1.0], left.blocks.count)
        return replace(found, moment=left.blocks.moment + (found.moment - left.blocks.moment) * sign[:, None])

    monkeypatch.setattr(record_changes, "blocks_with", scattered)
    found = accelerated.__wrapped__(by=2.0, heavier=1.2)
    assert len(asked) == 1
    assert len(asked[0]) == 1
    assert not found.causes
    assert found.verdict != "clean"


@cache
def shaken() -> Diagnosis:
    """A model that is right, and a held-out record in which something else moves the axis."""
    *made, check = records({})
    drive = lfilter([1.0], [1.0, -0.99], np.random.default_rng(3).standard_normal(len(check)))
    made = [*made, replace(check, tau_m=check.tau_m + 0.03 * drive)]
    return diagnose(fitted(made), made, FEW)


def test_a_record_that_no_parameters_simulate_beside_the_fitted_ones_is_not_clean() -> None:
    found = shaken()
    assert found.verdict == "unknown"
    assert found.apart == ("check",)
    assert "no fit of the model simulates both" in found.remarks[0]


def test_the_sentence_says_where_the_model_is_wrong() -> None:
    found = shaken()
    wrong = found.records["check"].misfit
    assert sentence(found) == (f"m leaves noise on the records of its fit and is wrong by {wrong:.2g} rad/s on check")


@pytest.mark.parametrize("seed", [1, 2])
def test_a_record_as_good_as_the_others_needs_no_fit_of_its_own(seed: int) -> None:
    made = records({}, seed=seed)
    found = diagnose(fitted(made), made, FEW)
    assert found.verdict == "clean"
    assert not found.remarks
