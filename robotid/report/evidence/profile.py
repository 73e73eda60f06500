"""Intervals of doubtful parameters by the profile of the cost (Bates & Watts 1988, chapter 6).

How far one parameter may go, all others refitted, before the fit is worse than chance allows. Where the model is far
from linear in a parameter, that is not the symmetric interval that a standard deviation gives.

A profile is that of an optimum, and takes some dozen refits. It is given up where a refit comes out better than the fit
itself, which is then no optimum, and where a refit's simulation settles worse than that of the fit: each window of it
that fails takes as long as all others together, and a dozen such refits several times as long as the fit. A parameter
has none where the residual's colour leaves fewer independent samples than there are parameters: what chance then allows
is a model many times worse than the fit, which says nothing of where the fit is uncertain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from robotid.diagnosis.refit.settings import REFIT
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.least_squares import SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.result import Estimate, FitResult
from robotid.interrupt import check
from robotid.model.array import Array
from robotid.numerals import number
from robotid.signals.record import Record

SIGMAS = 2.0  # the interval that stands beside it is two standard deviations wide on each side
DOUBTFUL = 0.25  # standard deviation over the value from which an estimate is doubtful
MAX_PARAMETERS = 3  # of a model, the most doubtful ones: each takes a dozen refits
MAX_SAMPLES = 100_000  # of all records together, beyond which a refit takes too long for a page
MAX_REFITS = 6  # for one end of an interval
CLOSE = 0.05  # of the distance to an end: so close it need not be found
UNLIKE = 0.2  # of the symmetric interval's half: a profile that differs by more is not the same interval
EFFORT = SolveOptions(max_iterations=10, tolerance=1e-7)

NO_FIT = "the fit cannot be simulated again"
TOO_LONG = f"more than {MAX_SAMPLES:,} samples"
TOO_COLOURED = (
    "along it the residual is so coloured that it counts as fewer independent samples than there are parameters"
)
NO_END = "farther from the fit the cost does not rise, or jumps"
TOO_SLOW = "with it elsewhere the model is simulated much more slowly, or not at all"


@dataclass(frozen=True, slots=True)
class ProfileInterval:
    """lower, upper : as far as the data allow, the parameter's bound where they allow all up to it. symmetric : much as
    the value and two robust standard deviations."""

    lower: float
    upper: float
    symmetric: bool


@dataclass(frozen=True, slots=True)
class Profiles:
    """Of the doubtful parameters of a fit, by name: intervals, and why there is none."""

    intervals: dict[str, ProfileInterval] = field(default_factory=dict)
    without: dict[str, str] = field(default_factory=dict)


class _GivenUp(Exception):
    """Why a parameter has no profile."""


class _NoOptimum(_GivenUp):
    """Why none has."""


def doubtful(fit: FitResult) -> list[Estimate]:
    """The estimates whose standard deviation is a large part of their value, the worst first."""
    found = [(p.std_robust / abs(p.value), p) for p in fit.parameters if not p.fixed and p.value]
    worst = sorted(((share, p) for share, p in found if DOUBTFUL < share < np.inf), key=lambda pair: -pair[0])
    return [p for _, p in worst[:MAX_PARAMETERS]]


def profile_intervals(fit: FitResult, records: Sequence[Record], horizon: float | None) -> Profiles:
    """Of the doubtful parameters of a fit. records : those of the fit. horizon [s] : of the pieces in which the fit
    simulated, None: whole records. Colour of the residual counts as it does in the standard deviations."""
    asked = doubtful(fit)
    if not asked or sum(map(len, records)) > MAX_SAMPLES:
        return Profiles(without={p.name: TOO_LONG for p in asked})
    try:
        profile = _Profile.of(fit, records, horizon)
    except NumericsError:
        return Profiles(without={p.name: NO_FIT for p in asked})
    found = Profiles()
    for p in asked:
        try:
            lower, upper = profile.ends(p)
        except _NoOptimum as why:
            return Profiles(without={p.name: str(why) for p in asked})
        except _GivenUp as why:
            found.without[p.name] = str(why)
        else:
            half = SIGMAS * p.std_robust
            symmetric = max(abs(p.value - lower - half), abs(upper - p.value - half)) < UNLIKE * half
            found.intervals[p.name] = ProfileInterval(lower, upper, symmetric)
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Profile:
    """The cost of a fit as a function of one parameter, the others at their best. optimum : where all are; factor :
    (m, m) there, as of `Solution`."""

    problem: OutputError
    optimum: Evaluation
    factor: Array
    samples: int

    @classmethod
    def of(cls, fit: FitResult, records: Sequence[Record], horizon: float | None) -> _Profile:
        """Raises NumericsError where the fit cannot be simulated."""
        model = fitted_model(fit)
        pieces = tuple(piece for record in records for piece in record.pieces(horizon))
        weights = np.array([1 / (fit.noise_std.get(piece.name, 0.0) or 1.0) for piece in pieces])
        problem = OutputError(model.joint, model.parameters, pieces, fit.output, weights)
        found = solve(problem, problem.start(), EFFORT)
        return cls(problem, found.evaluation, found.factor, sum(map(len, pieces)))

    def ends(self, p: Estimate) -> tuple[float, float]:
        """Where the profile leaves what chance allows, on both sides. Raises _GivenUp."""
        # a coloured residual tells less than its number of samples: by the ratio of the two standard deviations
        chance = p.std_robust / p.std if p.std > 0 else 1.0
        if self.samples / chance**2 < len(self.problem.columns):
            raise _GivenUp(TOO_COLOURED)
        return self._end(p, -1.0, chance), self._end(p, 1.0, chance)

    def _end(self, p: Estimate, side: float, chance: float) -> float:
        reach = SIGMAS * p.std_robust
        bound = p.upper if side > 0 else p.lower
        known: list[tuple[float, float]] = []  # distances, and the excess there over what chance allows
        for _ in range(MAX_REFITS):
            check()
            at = p.value + side * reach
            limited = bool((at - bound) * side >= 0)
            at = bound if limited else at
            worse = self._excess(p.name, at) / chance
            if worse < -1.0:
                raise _NoOptimum(f"the fit is better with {p.name} at {number(float(at), 3)}")
            ratio = max(worse, 0.0) / SIGMAS
            if abs(ratio - 1) < CLOSE or (limited and ratio < 1):
                return float(at)
            known = sorted([*known, (abs(at - p.value), ratio)])
            if any(farther < nearer - CLOSE for (_, nearer), (_, farther) in pairwise(known)):
                break
            reach = abs(at - p.value) * float(np.clip(1 / max(ratio, 1e-3), 0.2, 5.0))
        raise _GivenUp(NO_END)

    def _excess(self, name: str, value: float) -> float:
        """How much worse the fit is with a parameter there, in standard deviations, negative where it is better. Raises
        _GivenUp where it cannot be simulated as the fit was."""
        joint, parameters = self.problem.joint, self.problem.parameters
        k = joint.names.index(name)
        values, free = parameters.values.copy(), parameters.free.copy()
        values[k], free[k] = value, False
        there = replace(parameters, values=values, free=free)
        limit = max(REFIT.patience, _failed_windows(self.optimum))
        problem = replace(self.problem, parameters=there, max_failed_windows=limit)
        found = self._refitted(problem, self.problem.columns.index(k), value)
        change = (found.cost / self.optimum.cost - 1) * self.samples
        return float(np.copysign(np.sqrt(abs(change)), change))

    def _refitted(self, problem: OutputError, k: int, value: float) -> Evaluation:
        """The others at their best, the k-th unknown at a value."""
        for start in (self._followed(k, value), np.delete(self.optimum.unknowns, k)):
            try:
                refit = solve(problem, start, EFFORT)
            except NumericsError:
                continue
            moved = len(refit.cost) > 1  # a joint that friction holds has no derivative that would show a way out
            if moved and _failed_windows(refit.evaluation) <= _failed_windows(self.optimum):
                return refit.evaluation
        raise _GivenUp(TOO_SLOW)

    def _followed(self, k: int, value: float) -> Array:
        """All unknowns but the k-th, (m - 1,), where the linear model has its lowest cost once that one is `value`.

        A refit that starts there is near its end; but far from the fit this may be where friction holds the joint.
        """
        others = np.delete(self.factor, k, axis=1)
        step = np.linalg.lstsq(others, -self.factor[:, k] * (value - self.optimum.unknowns[k]), rcond=None)[0]
        return np.asarray(np.delete(self.optimum.unknowns, k) + step)


def _failed_windows(evaluation: Evaluation) -> int:
    """How many its worst simulation needed."""
    return max(trajectory.failed_windows for trajectory in evaluation.trajectories)
