"""A torque of any shape along the motor's speed, as a term of the model: what a curve explains once it acts.

Along the speed a curve feeds back on what it depends on; the columns of a curve, along the motion as it was, leave that
out. Along an angle or the time there is little of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.judge.trial import Bench, Trial, try_model
from robotid.model.array import Array
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term

PATIENCE = 4  # windows that may fail to settle: a curve with more is no friction that exists
MOST_ITERATIONS = 4  # of a refit: the next sweep goes on


class FreeCurve(Term):
    """An applied torque, piecewise linear along the speed.

    knots [rad/s], values [Nm] (k,); a knot that is there twice is one on either side of a jump, which is dry friction.
    """

    name = "free_curve"
    ports = (Port.MOTOR,)
    parameters = ()
    formula = "-curve(v)"
    source = "none: a shape, not a law"
    signature = "any along the speed"

    def __init__(self, knots: Array, values: Array) -> None:
        twice = np.flatnonzero(np.diff(knots) == 0.0)
        cut = [int(twice[0]) + 1] if twice.size else []
        self._sides = list(zip(np.split(knots, cut), np.split(values, cut), strict=True))

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return -self._level(m)[0]

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        _, slope, jump = self._level(m)
        return Partials(v=-slope, s=-jump if len(self._sides) > 1 else 0.0)

    def _level(self, m: Motion) -> tuple[Array, Array, Array]:
        """The curve, its slope, and its derivative to the direction, (n,) each."""
        found = [_piecewise(m.v, knots, values) for knots, values in self._sides]
        (low, slope_low), (high, slope_high) = found[0], found[-1]
        right = (1.0 + m.s) / 2
        return low + right * (high - low), slope_low + right * (slope_high - slope_low), (high - low) / 2


def _piecewise(x: Array, knots: Array, values: Array) -> tuple[Array, Array]:
    """A curve, constant beyond its ends, and its slope."""
    slopes = np.concatenate([[0.0], np.diff(values) / np.diff(knots), [0.0]])
    return np.interp(x, knots, values), slopes[np.searchsorted(knots, x)]


def with_curve(trial: Trial, bench: Bench, term: FreeCurve, moved: Array) -> Trial:
    """The model refitted with a curve as it is, from parameters (k,) moved along with it. Raises NumericsError."""
    joint, parameters = trial.problem.joint, trial.parameters
    extended = joint.with_more(terms=[(Port.MOTOR, term)])
    values = parameters.values.copy()
    values[list(trial.problem.columns)] += moved
    start = parameters.with_values(np.clip(values, parameters.lower, parameters.upper))
    return try_model(extended, [start, parameters], bench, trial.motions, patience=PATIENCE, most=MOST_ITERATIONS)
