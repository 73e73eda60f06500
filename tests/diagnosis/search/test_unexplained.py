"""A curve that no effect explains is told where it is no noise, and no event stands in its place that explains less."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.plain_models import SAMPLES, plain_data, plain_model

from robotid.diagnosis.nonparametric.basis import Basis, Variable
from robotid.diagnosis.nonparametric.curve_fit import FittedCurve
from robotid.diagnosis.search import unexplained
from robotid.diagnosis.search.search import replaces_the_curve
from robotid.diagnosis.search.state import SearchResult
from robotid.model.array import Array

LEVEL = 1e-3


def a_curve(along: str, *decrease: Array) -> FittedCurve:
    basis = Basis(Variable(along, ""), np.zeros(1), (), 1.0, np.zeros(1))
    return FittedCurve(basis, SimpleNamespace(along=along), 0.0, np.zeros(1), np.zeros(3), decrease)  # type: ignore[arg-type]


def p_value(in_the_fit: float, *decrease: Array, monkeypatch: pytest.MonkeyPatch) -> float:
    monkeypatch.setattr(unexplained, "curve_p_value", lambda *_: in_the_fit)
    return unexplained._p_value(a_curve("phi_m", *decrease), plain_model(1.0))


def test_a_gain_on_records_that_served_for_no_fit_counts_with_these(monkeypatch: pytest.MonkeyPatch) -> None:
    everywhere = 1.0 + 0.1 * np.random.default_rng(1).standard_normal(SAMPLES)
    assert p_value(5e-3, everywhere, monkeypatch=monkeypatch) < LEVEL


def test_without_such_records_the_fitted_ones_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    assert p_value(5e-3, monkeypatch=monkeypatch) == 5e-3


def result(left: float, curve: FittedCurve | None = None) -> SearchResult:
    """A search whose first model leaves ten thousand variances of the noise beyond it, and its last one so many."""
    first, last = plain_model(SAMPLES + 1e4), plain_model(SAMPLES + left)
    made: dict[str, Any] = {"curve": curve, "curve_share": 1.0}
    return SearchResult(plain_data(), first, last, (), (), (), **made)


@pytest.mark.parametrize(("left", "replaces"), [(100.0, True), (300.0, False)])
def test_an_event_must_explain_as_much_as_a_curve_along_the_motion(left: float, *, replaces: bool) -> None:
    """A curve has many more parameters, and may explain a little more."""
    assert replaces_the_curve(result(left), result(1e4, a_curve("dphi_m"))) is replaces


@pytest.mark.parametrize("curve", [None, a_curve("t")])
def test_a_curve_along_time_is_another_look_at_an_event(curve: FittedCurve | None) -> None:
    assert replaces_the_curve(result(3000.0), result(1e4, curve))
