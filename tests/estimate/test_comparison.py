"""Fits side by side: what is called different, and how often by chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom
from support.handed_models import fit_of

from robotid.errors import ConfigError
from robotid.estimate.comparison import compare_fits, holm
from robotid.estimate.result import FitResult
from robotid.model.array import Array
from robotid.model.structure import Structure

RIGID = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TRUE = np.array([0.01, 0.02, 0.4])
SPREAD = np.array([1e-5, 1e-4, 2e-3])
CORRELATION = np.array([[1.0, 0.3, 0.0], [0.3, 1.0, -0.9], [0.0, -0.9, 1.0]])


def fit(values: Array, scale: float = 1.0) -> FitResult:
    """A fit with these values, whose errors are as SPREAD and CORRELATION say, times a scale."""
    made = fit_of(RIGID, {})
    covariance = CORRELATION * np.outer(SPREAD, SPREAD) * scale**2
    parameters = tuple(
        replace(p, value=float(v), std=0.1 * s, std_robust=s)
        for p, v, s in zip(made.parameters, values, (SPREAD * scale).tolist(), strict=True)
    )
    return replace(made, parameters=parameters, covariance=0.01 * covariance, covariance_robust=covariance)


def drawn(generator: np.random.Generator, scale: float = 1.0) -> FitResult:
    return fit(TRUE + generator.multivariate_normal(np.zeros(3), np.outer(SPREAD, SPREAD) * CORRELATION) * scale, scale)


def test_a_large_difference_is_significant_and_named_with_its_uncertainty() -> None:
    found = compare_fits({"monday": fit(TRUE), "friday": fit(TRUE + np.array([0.0, 0.0, 0.05]), 2.0)})
    (changed,) = found.changed
    assert (changed.parameter, changed.run) == ("motor.coulomb.Fc", "friday")
    assert changed.value == pytest.approx(0.05)
    assert changed.std == pytest.approx(2e-3 * np.sqrt(5.0))
    assert found.whole[0].differs
    assert found.whole[0].degrees == 3


def test_correlated_parameters_differ_together_where_none_does_alone() -> None:
    """Along a direction that the correlation makes certain, a shift of each within its own uncertainty is no chance."""
    shift = 1.6 * SPREAD * [0.0, 1.0, 1.0]
    found = compare_fits({"a": fit(TRUE), "b": fit(TRUE + shift)})
    assert not found.changed
    assert found.whole[0].differs


def test_unchanged_runs_differ_as_often_as_the_level_allows() -> None:
    generator, draws, level = np.random.default_rng(5), 400, 0.05
    some, together = 0, 0
    for _ in range(draws):
        found = compare_fits(
            {name: drawn(generator, scale) for name, scale in (("a", 1.0), ("b", 2.0), ("c", 0.5))}, level
        )
        some += bool(found.changed)
        together += any(one.differs for one in found.whole)
    low, high = binom.ppf([0.001, 0.999], draws, level)
    assert some <= high
    assert low / 3 <= together <= high
    assert some > 0


def test_a_parameter_that_was_fixed_is_shown_and_not_tested() -> None:
    first = fit(TRUE)
    fixed = replace(first.parameters[0], fixed=True, std=float("nan"), std_robust=float("nan"), value=0.5)
    found = compare_fits({"a": replace(first, parameters=(fixed, *first.parameters[1:])), "b": first})
    inertia = found.differences[0]
    assert np.isnan(inertia.p_value)
    assert not inertia.differs
    assert found.whole[0].degrees == 2


def test_holm_corrects_for_what_was_tested_alone() -> None:
    assert holm([0.01, float("nan"), 0.04, 0.03])[0] == pytest.approx(0.03)
    assert holm([0.01, float("nan"), 0.04, 0.03])[2:] == pytest.approx([0.06, 0.06])
    assert np.isnan(holm([0.01, float("nan")])[1])
    assert holm([0.9, 0.8]) == [1.0, 1.0]


def test_one_run_or_axes_of_two_kinds_are_refused() -> None:
    with pytest.raises(ConfigError, match="nothing to compare with"):
        compare_fits({"a": fit(TRUE)})
    sliding = replace(fit(TRUE), structure=replace(RIGID, linear=True))
    with pytest.raises(ConfigError, match="b is an axis that slides, a is not"):
        compare_fits({"a": fit(TRUE), "b": sliding})
