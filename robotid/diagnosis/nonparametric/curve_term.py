"""A torque of any shape along one variable of the motion, as a term of the model: what a curve explains once it acts.

A curve feeds back on what it depends on, and moves the motion that it lies along; the columns of a curve, along the
motion as it was, leave that out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.diagnosis.misfit.curve import BY_ACCELERATION, BY_DIRECTION, BY_SPEED
from robotid.diagnosis.nonparametric.basis import Variable, sides
from robotid.diagnosis.nonparametric.settings import CURVES
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import RefitOptions, refit
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term

ARGUMENT = {"dphi_m": "v", "phi_m": "x", "twist": "x", "dtwist": "v", "t": "t"}  # of a term's motion, by variable
FACTOR = {BY_DIRECTION: "s", BY_SPEED: "v", BY_ACCELERATION: "a"}  # likewise, of a curve that is counted so


class FreeCurve(Term):
    """An applied torque, piecewise linear along a variable of its port's motion.

    knots (k,), a knot that is there twice is one on either side of a jump, which is dry friction; values [Nm] (k,), or
    what the variable counts. Along what is no state of its port, such as the acceleration or, of
    the gear, the motor's angle, no curve can act: see `can_act`.
    """

    name = "free_curve"
    ports = (Port.MOTOR, Port.GEAR)
    parameters = ()
    formula = "-curve"
    source = "none: a shape, not a law"
    signature = "any along one variable"

    def __init__(self, variable: Variable, knots: Array, values: Array) -> None:
        self._variable = variable
        self._sides = [(knots[at], values[at]) for at in sides(knots)]

    @property
    def argument(self) -> str:
        """What of the motion it runs along."""
        return ARGUMENT[self._variable.along]

    @property
    def port(self) -> Port:
        """Where it acts."""
        return Port.GEAR if self._variable.gear else Port.MOTOR

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(-self._level(m)[0] * self._factor(m))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        level, slope, jump = self._level(m)
        factor, counted = self._factor(m), self._variable.counted
        along = {self.argument: -slope * factor}
        v = -level if counted == BY_SPEED else along.get("v", 0.0)
        s = -level if counted == BY_DIRECTION else -jump if len(self._sides) > 1 else 0.0
        a = -level if counted == BY_ACCELERATION else 0.0
        return Partials(x=along.get("x", 0.0), v=v, a=a, s=s)

    def _factor(self, m: Motion) -> Array | float:
        counted = self._variable.counted
        return getattr(m, FACTOR[counted]) if counted else 1.0

    def _level(self, m: Motion) -> tuple[Array, Array, Array]:
        """The curve, its slope, and its derivative to the direction, (n,) each."""
        x: Array = getattr(m, self.argument)
        found = [_piecewise(x, knots, values) for knots, values in self._sides]
        (low, slope_low), (high, slope_high) = found[0], found[-1]
        right = (1.0 + m.s) / 2
        return low + right * (high - low), slope_low + right * (slope_high - slope_low), (high - low) / 2


def can_act(variable: Variable, joint: Joint) -> bool:
    """Whether a curve along a variable can be a term; behind a transform of the gear's motion it would read another
    twist than the one that it was fitted along."""
    transformed = any(place.transform is not None and place.port is Port.GEAR for place in joint.placed)
    known = variable.along in ARGUMENT and variable.counted in ("", *FACTOR)
    return known and not (variable.gear and transformed)


def _piecewise(x: Array, knots: Array, values: Array) -> tuple[Array, Array]:
    """A curve, constant beyond its ends, and its slope."""
    slopes = np.concatenate([[0.0], np.diff(values) / np.diff(knots), [0.0]])
    return np.interp(x, knots, values), slopes[np.searchsorted(knots, x)]


def refit_with_curve(
    joint: Joint, near: RefittedModel, data: EvaluationData, curve: FreeCurve, moved: Array
) -> RefittedModel:
    """A joint refitted with a curve as it is, from the parameters of a model nearby, moved (k,) along with the curve.

    Raises NumericsError where it cannot be simulated.
    """
    extended = joint.with_more(terms=[(curve.port, curve)])
    return refit(extended, starts_along(near, moved), data, near.trajectories, sweep_options())


def starts_along(near: RefittedModel, moved: Array) -> list[Parameters]:
    """Where a refit with a curve starts: the parameters of a model nearby moved (k,) along with the curve, or as they
    are."""
    parameters = near.parameters
    values = parameters.values.copy()
    values[list(near.columns)] += moved
    return [parameters.with_values(np.clip(values, parameters.lower, parameters.upper)), parameters]


def sweep_options() -> RefitOptions:
    """How far a refit with a curve goes."""
    return RefitOptions(patience=CURVES.patience, max_iterations=CURVES.max_iterations)
