"""Promises that every term keeps, over the registry: a new file is covered at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robotid.model.parameters import Parameter
from robotid.model.term import Motion, Partials, Term
from robotid.terms import TERMS

SAMPLES = 40
STEP = 1e-30
ARGUMENTS = ("x", "v", "a", "s")

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
    return Motion(x, v, a, s, t, rng.normal(size=(len(term.states), SAMPLES)))


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
    return Motion(*(np.asarray(getattr(m, k), dtype=complex) for k in ("x", "v", "a", "s", "t", "z")))


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
    """The torque and the rate of every state, each with its partials."""
    rates: list[Any] = [
        (lambda m, p, i=i: term.rate(m, p)[i], lambda m, p, i=i: term.rate_partials(m, p)[i])
        for i in range(len(term.states))
    ]
    return [(term.torque, term.partials), *rates]


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
    m, p = moving(term, seed), at_null(term, seed)
    assert np.all(np.asarray(term.torque(m, p)) == 0.0)
    assert not any(np.any(getattr(term.partials(m, p), name)) for name in ARGUMENTS)


@vanishing
def test_missing_effect_can_be_scored_at_its_null(term: Term) -> None:
    columns = term.partials(moving(term, 0), at_null(term, 0)).theta
    for parameter, column in zip(term.parameters, columns, strict=True):
        if parameter.null is not None:
            assert np.any(column), parameter.symbol


@shaped
def test_shape_is_unseen_while_the_effect_is_absent(term: Term) -> None:
    columns = term.partials(moving(term, 0), at_null(term, 0)).theta
    for parameter, column in zip(term.parameters, columns, strict=True):
        if parameter.is_shape:
            assert parameter.null is None
            assert not np.any(column), parameter.symbol


@every_term
def test_a_fit_can_start_from_the_guess(term: Term) -> None:
    guess = [p.guess for p in term.parameters]
    shown = (term.partials(moving(term, 0), guess), *term.rate_partials(moving(term, 0), guess))
    for k, parameter in enumerate(term.parameters):
        assert any(np.any(d.theta[k]) for d in shown), f"{parameter.symbol} cannot be seen from its guess"
