"""Fits side by side: which parameters differ by more than their uncertainties allow.

A difference of two independent estimates has the sum of their covariances. Parameter by parameter that is a normal
test, corrected for how many were made (Holm 1979): of fits of one machine, some parameter of some run is called
different in no more than `level` of all comparisons. All parameters of two runs together differ by a Wald test, which
knows of their correlations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np
from scipy.stats import chi2, norm

from robotid.errors import ConfigError
from robotid.estimate.result import Estimate, FitResult
from robotid.model.array import Array

LEVEL = 0.01  # of significance, after the correction
DEPENDENT = 1e-10  # eigenvalue of the scaled covariance below which a direction has no uncertainty to compare by


@dataclass(frozen=True, slots=True)
class Difference:
    """A parameter of a run less that of the first run.

    std : of the difference; p_value : of none, corrected for the number of parameters and runs; both nan where the
    parameter was not estimated in both. differs : whether the difference is significant.
    """

    parameter: str
    run: str
    value: float
    std: float
    p_value: float
    differs: bool


@dataclass(frozen=True, slots=True)
class WholeDifference:
    """All parameters that two runs have estimated. statistic : the squared distance in standard deviations; p_value :
    of its being so large by chance, corrected for the number of runs."""

    run: str
    statistic: float
    degrees: int
    p_value: float
    differs: bool


@dataclass(frozen=True, slots=True, eq=False)
class FitComparison:
    """Fits by run, the first of them the one that the others are compared with. level : of significance."""

    fits: Mapping[str, FitResult]
    differences: tuple[Difference, ...]
    whole: tuple[WholeDifference, ...]
    level: float = LEVEL

    @property
    def reference(self) -> str:
        """The run that the others are compared with."""
        return next(iter(self.fits))

    @property
    def changed(self) -> tuple[Difference, ...]:
        """The significant ones, the most certain first."""
        return tuple(sorted((d for d in self.differences if d.differs), key=lambda d: d.p_value))


def compare_fits(fits: Mapping[str, FitResult], level: float = LEVEL) -> FitComparison:
    """Compare fits with the first of them. Raises ConfigError for fewer than two, and for axes of different kinds."""
    if len(fits) < 2:
        raise ConfigError("there is nothing to compare with", where="compare", hint="give two runs or more")
    reference, *others = fits
    for run in others:
        if fits[run].structure.linear != fits[reference].structure.linear:
            what = f"{run} is an axis that {'slides' if fits[run].structure.linear else 'turns'}, {reference} is not"
            raise ConfigError(what, where="compare", hint="compare axes of one kind")
    found = [_difference(fits[reference], fits[run], name, run) for run in others for name in _names(fits, run)]
    corrected = holm([one.p_value for one in found])
    differences = tuple(
        Difference(one.parameter, one.run, one.value, one.std, p, bool(p < level))
        for one, p in zip(found, corrected, strict=True)
    )
    whole = [_whole(fits[reference], fits[run], run) for run in others]
    together = tuple(
        WholeDifference(one.run, one.statistic, one.degrees, p, bool(p < level))
        for one, p in zip(whole, holm([one.p_value for one in whole]), strict=True)
    )
    return FitComparison(dict(fits), differences, together, level)


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values corrected for their number (Holm 1979); those that are nan stay, and do not count."""
    tested = sorted((p, k) for k, p in enumerate(p_values) if isfinite(p))
    corrected, least = list(p_values), 0.0
    for rank, (p, k) in enumerate(tested):
        least = max(least, min(1.0, (len(tested) - rank) * p))
        corrected[k] = least
    return corrected


def uncertainty(p: Estimate) -> float:
    """Standard deviation of an estimate, robust where it is known; nan of one that was not estimated."""
    return p.std_robust if isfinite(p.std_robust) else p.std


def _names(fits: Mapping[str, FitResult], run: str) -> list[str]:
    """Parameters that a run shares with the first."""
    first = {p.name for p in next(iter(fits.values())).parameters}
    return [p.name for p in fits[run].parameters if p.name in first]


def _difference(first: FitResult, other: FitResult, name: str, run: str) -> Difference:
    a, b = first[name], other[name]
    value, std = b.value - a.value, sqrt(uncertainty(a) ** 2 + uncertainty(b) ** 2)
    p = float(2.0 * norm.sf(abs(value) / std)) if isfinite(std) and std > 0 else float("nan")
    return Difference(name, run, value, std if isfinite(std) else float("nan"), p, False)


def _whole(first: FitResult, other: FitResult, run: str) -> WholeDifference:
    """The Wald test of all parameters that both have estimated."""
    names = [p.name for p in first.parameters if _estimated(first, p.name) and _estimated(other, p.name)]
    if not names:
        return WholeDifference(run, 0.0, 0, 1.0, False)
    distance = np.array([other[name].value - first[name].value for name in names])
    covariance = _covariance(first, names) + _covariance(other, names)
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(np.float64).tiny))
    variances, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    along = axes.T @ (distance / scale)
    kept = variances > DEPENDENT
    statistic = float(np.sum(along[kept] ** 2 / variances[kept]))
    degrees = int(kept.sum())
    return WholeDifference(run, statistic, degrees, float(chi2.sf(statistic, degrees)), False)


def _estimated(fit: FitResult, name: str) -> bool:
    found = next((p for p in fit.parameters if p.name == name), None)
    return found is not None and isfinite(uncertainty(found)) and uncertainty(found) > 0.0


def _covariance(fit: FitResult, names: Sequence[str]) -> Array:
    every = [p.name for p in fit.parameters]
    at = [every.index(name) for name in names]
    robust = all(isfinite(fit[name].std_robust) for name in names)
    return np.asarray((fit.covariance_robust if robust else fit.covariance)[np.ix_(at, at)])
