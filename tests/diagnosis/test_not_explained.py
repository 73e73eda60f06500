"""A model that does not simulate its own records is never clean, whatever the noise; noise-free records are."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.small_bench import fitted, records

from robotid.diagnosis import Criteria, Diagnosis, diagnose
from robotid.diagnosis.verdict import explained_variance
from robotid.report.tables import diagnose as tables

CRITERIA = Criteria(max_causes=1, max_refits=1, skip=("record_change",))


@cache
def unrelated() -> Diagnosis:
    """A model on records whose output is another signal."""
    made = records({})
    fit = fitted(list(made))
    rng = np.random.default_rng(3)
    other = [replace(r, dphi_m=np.std(r.dphi_m) * rng.standard_normal(len(r))) for r in made]
    return diagnose(fit, other, CRITERIA)


def test_a_model_that_does_not_simulate_its_records_is_not_clean() -> None:
    assert unrelated().verdict == "not explained"
    assert max(m.fit_percent for m in unrelated().records.values()) < 10.0
    assert "`robotid check`" in unrelated().remarks[0]


def test_no_cause_is_named_and_the_noise_is_not_known() -> None:
    assert unrelated().causes == ()
    assert np.isnan(unrelated().noise_floor)
    assert unrelated().misfit == unrelated().remaining > 0.0


def test_the_verdict_is_a_sentence_and_a_word() -> None:
    assert "does not simulate the records that it was fitted to" in tables.sentence(unrelated())
    assert tables.document(unrelated())["verdict"] == "not explained"  # type: ignore[call-overload, index]


@pytest.mark.parametrize(("left", "share"), [(0.0, 1.0), (0.5, 0.75), (1.0, 0.0), (2.0, -3.0)])
def test_the_share_of_the_variance_that_is_explained(left: float, share: float) -> None:
    y = np.sin(np.linspace(0.0, 20.0 * np.pi, 5000)) + 7.0
    found = explained_variance({"a": y, "b": y}, {"a": left * (y - y.mean()), "b": left * (y - y.mean())})
    assert found == pytest.approx(share)


def test_records_without_noise_are_clean() -> None:
    made = records({}, quiet=True)
    found = diagnose(fitted(list(made)), made, CRITERIA)
    assert (found.verdict, found.causes, found.misfit) == ("clean", (), 0.0)


def test_records_without_noise_whose_rounding_has_a_shape_are_clean() -> None:
    made = records({}, quiet=True)
    rounded = [replace(r, dphi_m=r.dphi_m + 1e-8 * r.phi_m, phi_m=np.round(r.phi_m, 9)) for r in made]
    assert diagnose(fitted(list(rounded)), rounded, CRITERIA).verdict == "clean"


def test_nothing_is_explained_where_nothing_varies() -> None:
    assert explained_variance({"a": np.ones(5)}, {"a": np.zeros(5)}) == 0.0
