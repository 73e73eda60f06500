"""Torques that are in no catalogue: the verdict is unknown, with the variable that orders them and their shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from support.followed_curve import correlation_beyond, followed, imitable
from support.small_bench import (
    AXIS,
    DURATION,
    SAMPLING_TIME,
    TRUTH,
    begun,
    fitted,
    made_along,
    records_of,
    searched,
    simulated,
)

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.nonparametric.curve_fit import fit_acting, fit_curves
from robotid.diagnosis.results import Diagnosis
from robotid.diagnosis.verdict import verdict
from robotid.estimate.fitted_model import fitted_model
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term
from robotid.signals.record import Record
from robotid.terms import TERMS

CENTRE, WIDTH = 8.0, 2.5  # rad/s
ALIKE = 0.95
SMOOTH = 5  # samples: what of a noisy speed is motion


class Unlisted(Term):
    """An effect of the tests alone."""

    name = "unlisted"
    ports = (Port.MOTOR,)
    parameters = (Parameter("A", "Nm", "size", guess=0.1, bounds=(-1e3, 1e3), null=0.0),)
    formula = source = signature = "of the tests alone"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        return np.asarray(p[0] * self.shape(m.v, m.x))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        to_x, to_v = self.slopes(m.v, m.x)
        return Partials(x=p[0] * to_x, v=p[0] * to_v, theta=(self.shape(m.v, m.x),))

    def shape(self, v: Array, x: Array) -> Array:
        raise NotImplementedError

    def slopes(self, v: Array, x: Array) -> tuple[Array, Array]:
        raise NotImplementedError


class Bump(Unlisted):
    """Friction that is higher at one speed, either way."""

    def shape(self, v: Array, x: Array) -> Array:
        return np.asarray(np.sign(v) * np.exp(-(((np.abs(v) - CENTRE) / WIDTH) ** 2)))

    def slopes(self, v: Array, x: Array) -> tuple[Array, Array]:
        return np.zeros_like(v), -2 * (np.abs(v) - CENTRE) / WIDTH**2 * np.abs(self.shape(v, x))


class NarrowBump(Bump):
    """A third as wide."""

    def shape(self, v: Array, x: Array) -> Array:
        return np.asarray(np.sign(v) * np.exp(-((3 * (np.abs(v) - CENTRE) / WIDTH) ** 2)))

    def slopes(self, v: Array, x: Array) -> tuple[Array, Array]:
        return np.zeros_like(v), -18 * (np.abs(v) - CENTRE) / WIDTH**2 * np.abs(self.shape(v, x))


class Product(Unlisted):
    """Damping that grows with the position."""

    def shape(self, v: Array, x: Array) -> Array:
        return np.asarray(v * x)

    def slopes(self, v: Array, x: Array) -> tuple[Array, Array]:
        return v, x


CASES: dict[str, tuple[Unlisted, float, str]] = {
    "bump": (Bump(), 0.1, "dphi_m"),
    "product": (Product(), 1e-3, "phi_m, by speed"),
}
"""Effect, size, and along what it is ordered."""


def recorded(term: Unlisted, size: float) -> list[Record]:
    listed = [(Port.MOTOR, TERMS[name.partition(".")[2]]) for name in AXIS.terms]
    joint = Joint(AXIS, [*listed, (Port.MOTOR, term)], angle=True)
    return records_of(joint, TRUTH | {"motor.unlisted.A": size})


@cache
def diagnosed(case: str) -> tuple[list[Record], Diagnosis]:
    made = recorded(*CASES[case][:2])
    found = searched(made, Criteria(skip=("power_friction", "record_change"), max_causes=2))
    return made, verdict(fitted_model(fitted(made)), simulated(made), found)


def likeness(curve: Curve, made: list[Record], term: Unlisted) -> float:
    """Correlation of the torque that a curve makes of the motion with the true one, but for what the fitted model can
    take of either."""
    told, true, taken = [], [], []
    for record in made[:2]:
        v, x = gaussian_filter1d(record.dphi_m, SMOOTH), record.phi_m
        told.append(followed(curve, {"dphi_m": v, "phi_m": x}[curve.along.partition(", ")[0]], v))
        true.append(-term.shape(v, x))
        taken.append(imitable(v, SAMPLING_TIME))
    return correlation_beyond(*map(np.concatenate, (told, true, taken)))


@pytest.mark.parametrize("case", CASES)
def test_the_verdict_is_unknown_and_nothing_is_named(case: str) -> None:
    _, d = diagnosed(case)
    assert (d.verdict, d.causes) == ("unknown", ())
    assert d.misfit > d.noise_floor
    assert d.remaining == pytest.approx(d.misfit, rel=0.1)


@pytest.mark.parametrize("case", CASES)
def test_the_shape_is_that_of_the_torque_along_what_orders_it(case: str) -> None:
    term, _, along = CASES[case]
    made, d = diagnosed(case)
    assert d.shape is not None
    assert d.shape.along == along
    assert d.shape.order > 0.9
    assert likeness(d.shape, made, term) >= ALIKE


def test_the_shape_of_another_torque_is_not_taken_for_it() -> None:
    """Else the correlation would show nothing."""
    made, d = diagnosed("bump")
    assert d.shape is not None
    assert likeness(d.shape, made, Product()) < 0.5


def test_the_size_of_the_bump_is_told_in_newton_metres() -> None:
    """Where the fit could not take it: the height over the speeds around it."""
    _, d = diagnosed("bump")
    assert d.shape is not None
    x, torque = d.shape.x, -np.sign(d.shape.x) * d.shape.missing_torque
    peak = np.interp(CENTRE, x, torque) + np.interp(-CENTRE, x, torque)
    around = np.interp(CENTRE + 2 * WIDTH, x, torque) + np.interp(-CENTRE - 2 * WIDTH, x, torque)
    assert (peak - around) / 2 == pytest.approx(0.1, rel=0.35)


@pytest.mark.parametrize(("term", "size", "knots"), [(NarrowBump(), 0.2, 48), (Product(), 1e-3, 24)])
def test_a_curve_has_as_many_knots_as_the_residual_asks_for(term: Unlisted, size: float, knots: int) -> None:
    state = begun(recorded(term, size))
    assert len(fit_curves(state.model, state.data)[0].values) == knots


@pytest.mark.parametrize("case", CASES)
def test_a_curve_that_acts_explains_the_misfit_on_the_records_held_out_as_well(case: str) -> None:
    state = begun(recorded(*CASES[case][:2]))
    model, data = state.model, state.data
    found = fit_acting(fit_curves(model, data)[0], model, data)
    assert found.energy > 0.95 * (model.energy - data.samples)
    assert found.validation_energy > 0.9 * (model.validation_energy - data.validation_samples)


def test_a_ripple_of_the_torque_constant_is_told_within_a_turn_in_proportion_to_the_torque() -> None:
    """Eight periods a turn, which a coarse curve would not see."""
    t = np.arange(round(DURATION / SAMPLING_TIME)) * SAMPLING_TIME
    far = {name: 30.0 * np.sin(2.0 * np.pi * t / period) for name, period in (("a", 4.0), ("b", 1.3), ("c", 2.5))}
    rippled = [replace(r, tau_m=r.tau_m * (1.0 + 0.03 * np.sin(8.0 * r.phi_m + 0.5))) for r in made_along(far)]
    state = begun(rippled)
    found = fit_curves(state.model, state.data)[0]
    assert found.curve.along == "phi_m mod 2 pi, by torque"
    assert found.energy > 0.9 * (state.model.energy - state.data.samples)
    fast = np.fft.rfft(found.values)
    assert np.argmax(np.abs(fast[1:])) + 1 == 8
