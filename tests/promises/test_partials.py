"""Promises that every term keeps, over the registry: a new file is covered at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robotid.model.parameters import Parameter
from robotid.model.term import Motion, MotionTransform, Partials, Term
from robotid.terms import TERMS

SAMPLES = 40
STEP = 1e-30
ARGUMENTS = ("x", "v", "a", "s", "tau", "xw", "vw")

every_term = pytest.mark.parametrize("term", TERMS.values(), ids=list(TERMS))
every_seed = pytest.mark.parametrize("seed", range(5))
vanishing = pytest.mark.parametrize(
    "term", [t for t in TERMS.values() if any(p.null is not None for p in t.parameters)], ids=lambda t: t.name
)
shaped = pytest.mark.parametrize(
    "term", [t for t in TERMS.values() if any(p.is_shape for p in t.parameters)], ids=lambda t: t.name
)


def moving(term: Term, seed: int) -> Motion:
    """A motion whose arguments have nothing to do with each other, sticking (s between -1 and 1) included."""
    rng = np.random.default_rng(seed)
    x, v, a = rng.normal(size=(3, SAMPLES)) * [[0.5], [2.0], [30.0]]
    s, t = rng.uniform(-1.0, 1.0, SAMPLES), np.sort(rng.uniform(0.0, 10.0, SAMPLES))
    m = Motion(x, v, a, s, t, rng.normal(size=(len(term.states), SAMPLES)))
    tau, xw, vw = rng.normal(size=(3, SAMPLES)) * [[5.0], [3.0], [20.0]]
    side = rng.choice([-1.0, 1.0], size=(len(term.edges), SAMPLES))
    m = replace(m, side=side, tau=tau if term.reads else 0.0)
    if term.companion:
        w, dw, ddw = rng.normal(size=(3, SAMPLES)) * [[1.0], [2.0], [10.0]]
        m = replace(m, w=w, dw=dw, ddw=ddw)
    return replace(m, xw=xw, vw=vw) if getattr(term, "watches", None) else m


def sided(term: Term, m: Motion, p: Sequence[float]) -> Motion:
    """The same motion on the sides of the term's edges that its distances tell."""
    return replace(m, side=np.sign(np.array(term.distance(m, p)))) if term.edges else m


def somewhere(parameter: Parameter, rng: np.random.Generator) -> float:
    """A value around the guess, never the null, within bounds."""
    value = (parameter.guess or 1.0) * float(rng.uniform(0.4, 2.5))
    return float(np.clip(value, *parameter.bounds))


def values(term: Term, seed: int) -> list[float]:
    rng = np.random.default_rng(100 + seed)
    return [somewhere(p, rng) for p in term.parameters]


def at_null(term: Term, seed: int) -> list[float]:
    pairs = zip(term.parameters, values(term, seed), strict=True)
    return [value if p.null is None else p.null for p, value in pairs]


def as_complex(m: Motion) -> Any:
    names = ("x", "v", "a", "s", "t", "z", "tau", "xw", "vw")
    return replace(m, **{name: np.asarray(getattr(m, name), dtype=complex) for name in names})


def along(quantity: Callable[[Motion, Any], Any], m: Motion, p: Sequence[float], argument: str, i: int) -> Any:
    """Derivative of a quantity to one argument by a complex step, (n,)."""
    moved, q = as_complex(m), [complex(value) for value in p]
    if argument == "theta":
        q[i] += 1j * STEP
    elif argument == "z":
        moved.z[i] += 1j * STEP
    else:
        moved = replace(moved, **{argument: getattr(moved, argument) + 1j * STEP})
    return np.broadcast_to(np.imag(quantity(moved, q)) / STEP, (SAMPLES,))


def quantities(term: Term) -> list[tuple[Callable[[Motion, Any], Any], Callable[[Motion, Any], Partials]]]:
    """The torque, the rate of every state, the distance to every edge and what a bend makes of the motion, each with
    its partials."""
    several: list[tuple[Any, Any, int]] = [
        (term.rate, term.rate_partials, len(term.states)),
        (term.distance, term.distance_partials, len(term.edges)),
    ]
    if isinstance(term, MotionTransform):
        several.append((term.transform, term.transform_partials, 3))
    one_by_one: list[Any] = [
        (lambda m, p, f=f, i=i: f(m, p)[i], lambda m, p, d=d, i=i: d(m, p)[i])
        for f, d, count in several
        for i in range(count)
    ]
    return [(term.torque, term.partials), *one_by_one]


def entries(term: Term, partials: Partials) -> list[tuple[str, int, Any]]:
    """Every partial as (argument, index, value)."""
    z, theta = partials.z or (0.0,) * len(term.states), partials.theta or (0.0,) * len(term.parameters)
    return [
        *((name, 0, getattr(partials, name)) for name in ARGUMENTS),
        *(("z", i, value) for i, value in enumerate(z)),
        *(("theta", i, value) for i, value in enumerate(theta)),
    ]


def is_structural_zero(partial: Any) -> bool:
    return type(partial) is float and partial == 0.0


@every_seed
@every_term
def test_partials_are_the_derivatives(term: Term, seed: int) -> None:
    m, p = moving(term, seed), values(term, seed)
    for quantity, partials in quantities(term):
        for argument, i, declared in entries(term, partials(m, p)):
            exact = along(quantity, m, p, argument, i)
            error = np.max(np.abs(declared - exact))
            assert error <= 1e-9 * np.max(np.abs(exact)), f"{argument}[{i}]"


@every_seed
@every_term
def test_structural_zeros_are_plain_and_honest(term: Term, seed: int) -> None:
    m, p = moving(term, seed), values(term, seed)
    for quantity, partials in quantities(term):
        for argument, i, declared in entries(term, partials(m, p)):
            absent = not np.any(along(quantity, m, p, argument, i))
            assert is_structural_zero(declared) is absent, f"{argument}[{i}]"


@every_term
def test_every_argument_has_its_partial(term: Term) -> None:
    m, p = moving(term, 0), values(term, 0)
    for _, partials in quantities(term):
        d = partials(m, p)
        assert len(d.theta) == len(term.parameters)
        assert len(d.z) == len(term.states)
    assert len(term.rate(m, p)) == len(term.rate_partials(m, p)) == len(term.states)
    assert len(term.distance(m, p)) == len(term.distance_partials(m, p)) == len(term.edges)


@every_seed
@every_term
def test_torque_is_affine_in_acceleration(term: Term, seed: int) -> None:
    m, p = moving(term, seed), values(term, seed)
    rest = np.zeros(SAMPLES)
    slope = term.partials(replace(m, a=rest), p).a
    predicted = term.torque(replace(m, a=rest), p) + slope * m.a
    np.testing.assert_allclose(np.broadcast_to(term.torque(m, p), (SAMPLES,)), predicted, rtol=1e-12)
    np.testing.assert_array_equal(term.partials(m, p).a, slope)


@every_term
def test_memory_does_not_read_acceleration(term: Term) -> None:
    m, p = moving(term, 0), values(term, 0)
    slow, fast = term.rate(m, p), term.rate(replace(m, a=m.a + 1e3), p)
    assert all(np.array_equal(one, other) for one, other in zip(slow, fast, strict=True))


@every_seed
@vanishing
def test_effect_vanishes_at_its_null(term: Term, seed: int) -> None:
    p = at_null(term, seed)
    m = sided(term, moving(term, seed), p)
    assert np.all(np.asarray(term.torque(m, p)) == 0.0)
    assert not any(np.any(getattr(term.partials(m, p), name)) for name in ARGUMENTS)
    if isinstance(term, MotionTransform):
        for name, bent, d in zip(("x", "v", "s"), term.transform(m, p), term.transform_partials(m, p), strict=True):
            np.testing.assert_array_equal(bent, getattr(m, name))
            for argument in ARGUMENTS:
                assert np.all(getattr(d, argument) == float(argument == name)), argument


def columns_at_null(term: Term, seed: int) -> list[Any]:
    """What each parameter adds at the null, to the torque or to the motion that others feel."""
    p = at_null(term, seed)
    m = sided(term, moving(term, seed), p)
    shown = term.transform_partials(m, p) if isinstance(term, MotionTransform) else (term.partials(m, p),)
    return [np.stack([np.broadcast_to(d.theta[k], SAMPLES) for d in shown]) for k in range(len(p))]


@vanishing
def test_missing_effect_can_be_scored_at_its_null(term: Term) -> None:
    for parameter, column in zip(term.parameters, columns_at_null(term, 0), strict=True):
        if parameter.null is not None:
            assert np.any(column), parameter.symbol


@shaped
def test_shape_is_unseen_while_the_effect_is_absent(term: Term) -> None:
    for parameter, column in zip(term.parameters, columns_at_null(term, 0), strict=True):
        if parameter.is_shape:
            assert parameter.null is None
            assert not np.any(column), parameter.symbol


@every_term
def test_a_fit_can_start_from_the_guess(term: Term) -> None:
    guess, m = [p.guess for p in term.parameters], moving(term, 0)
    for k, parameter in enumerate(term.parameters):
        shown = any(np.any(partials(m, guess).theta[k]) for _, partials in quantities(term))
        assert shown, f"{parameter.symbol} cannot be seen from its guess"


@pytest.mark.parametrize("term", [t for t in TERMS.values() if isinstance(t, MotionTransform)], ids=lambda t: t.name)
def test_speed_felt_behind_a_bend_is_linear_in_both_speeds(term: MotionTransform) -> None:
    m, p = moving(term, 0), values(term, 0)
    slower = replace(m, v=0.25 * m.v, vw=0.25 * m.vw)
    np.testing.assert_allclose(term.transform(slower, p)[1], 0.25 * np.asarray(term.transform(m, p)[1]), rtol=1e-12)


@pytest.mark.parametrize("term", [t for t in TERMS.values() if t.edges], ids=lambda t: t.name)
def test_nothing_jumps_at_an_edge_but_what_follows_the_speed(term: Term) -> None:
    """Sides change where their distance is zero; position and torque go on from there without a jump."""
    p, m = values(term, 0), moving(term, 0)
    for k in range(len(term.edges)):
        slope = term.distance_partials(m, p)[k].x
        at = sided(term, replace(m, x=m.x - np.asarray(term.distance(m, p)[k]) / slope), p)
        one, other = (
            replace(at, side=np.where(np.arange(len(at.side))[:, None] == k, s, at.side)) for s in (-1.0, 1.0)
        )
        quantity = (lambda m, p: term.transform(m, p)[0]) if isinstance(term, MotionTransform) else term.torque
        np.testing.assert_allclose(quantity(one, p), quantity(other, p), atol=1e-14)


@pytest.mark.parametrize("term", [t for t in TERMS.values() if t.state_limit < np.inf], ids=lambda t: t.name)
def test_states_stay_within_their_limit(term: Term) -> None:
    m, p = moving(term, 0), values(term, 0)
    m = replace(m, s=np.sign(m.v))
    for side in (-1.0, 1.0):
        rates = term.rate(replace(m, z=np.full((len(term.states), SAMPLES), side * term.state_limit)), p)
        assert all(np.all(side * np.asarray(rate) <= 1e-12) for rate in rates)
