"""What every effect, term or channel, says about itself is complete."""

from __future__ import annotations

import re
from dataclasses import replace
from importlib import import_module
from math import isfinite

import numpy as np
import pytest

from robotid.channels import CHANNELS
from robotid.model.channel import Channel
from robotid.model.derivatives import absent
from robotid.model.describe import describe
from robotid.model.port import Port, Signal
from robotid.model.term import Motion, MotionTransform, Oscillation, Role, Term
from robotid.terms import TERMS

EFFECTS: list[Term | Channel] = [*TERMS.values(), *CHANNELS.values()]

every_effect = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


def test_no_name_is_taken_twice() -> None:
    assert not TERMS.keys() & CHANNELS.keys()


@every_effect
def test_name_is_that_of_its_file(effect: Term | Channel) -> None:
    assert type(effect).__module__.split(".")[-1] == effect.name


@every_effect
def test_texts_are_there(effect: Term | Channel) -> None:
    for text in (effect.formula, effect.source, effect.signature):
        assert text.strip()


@every_effect
def test_docstring_says_what_it_is_and_how_it_shows_itself(effect: Term | Channel) -> None:
    text = " ".join((type(effect).__dict__["__doc__"] or "").split())
    assert f"Shows itself as {effect.signature}." in text
    assert not text.startswith("Shows itself")


@every_effect
def test_class_is_the_only_thing_that_a_file_specifies(effect: Term | Channel) -> None:
    assert (import_module(type(effect).__module__).__doc__ or "").strip()
    assert not vars(type(effect)).keys() & {"__init__", "__slots__"}


@every_effect
def test_acts_somewhere(effect: Term | Channel) -> None:
    places = describe(effect).ports
    assert places
    assert set(places) <= {*map(str, Port if isinstance(effect, Term) else Signal)}


@every_effect
def test_formula_mentions_every_parameter(effect: Term | Channel) -> None:
    words = set(re.findall(r"[A-Za-z]\w*", effect.formula))
    assert {p.symbol for p in effect.parameters} <= words


@every_effect
def test_parameters_are_declared_in_full(effect: Term | Channel) -> None:
    assert effect.parameters
    assert len({p.symbol for p in effect.parameters}) == len(effect.parameters)
    for p in effect.parameters:
        assert p.symbol.isidentifier()
        assert p.unit.strip()
        assert p.meaning.strip()


@every_effect
def test_guess_null_and_grid_lie_within_bounds(effect: Term | Channel) -> None:
    for p in effect.parameters:
        lower, upper = p.bounds
        assert isfinite(p.guess)
        assert lower < upper
        for value in (p.guess, *p.grid, *([] if p.null is None else [p.null])):
            assert lower <= value <= upper, p.symbol
        assert list(p.grid) == sorted(set(p.grid))


@every_effect
def test_only_an_effect_that_vanishes_has_a_shape(effect: Term | Channel) -> None:
    if any(p.is_shape for p in effect.parameters):
        assert any(p.null is not None for p in effect.parameters)


def _motion(term: Term, size: float) -> Motion:
    """A motion with its states, a friction's direction apart; twice the size is twice all of it."""
    one = np.full(1, size)
    states = np.full((len(term.states), 1), 0.2 * size)
    sides = np.ones((len(term.edges), 1))
    m = Motion(0.3 * one, 0.7 * one, 1.1 * one, np.ones(1), np.ones(1), states, tau=0.5 * one, side=sides)
    return replace(m, w=np.full(1, 0.4), dw=np.full(1, 0.6), ddw=np.full(1, 0.9))


@pytest.mark.parametrize("term", TERMS.values(), ids=lambda term: term.name)
def test_linear_is_what_is_linear(term: Term) -> None:
    """Also the rates of the states. A transform has no torque to be linear."""
    p = [q.guess or 0.5 for q in term.parameters]
    once, doubled = _motion(term, 1.0), _motion(term, 2.0)
    small, large = ([float(np.squeeze(y)) for y in (term.torque(m, p), *term.rate(m, p))] for m in (once, doubled))
    twice = np.allclose(large, 2.0 * np.array(small), rtol=1e-12)
    reads_direction = not absent(term.partials(once, p).s)
    transforms = isinstance(term, MotionTransform)
    alone = term.reads is None and term.companion is None
    assert term.linear is (twice and not reads_direction and alone and not transforms)


@pytest.mark.parametrize("term", TERMS.values(), ids=lambda term: term.name)
def test_a_role_is_that_of_the_first_parameter(term: Term) -> None:
    units = {Role.MASS: "kg m2", Role.SPRING: "Nm/rad", Role.DAMPER: "Nm s/rad"}
    if term.role is not Role.NONE:
        assert term.parameters[0].unit.startswith(units[term.role])


@pytest.mark.parametrize("term", [t for t in TERMS.values() if t.linear], ids=lambda term: term.name)
def test_a_linear_term_is_sized_by_values_within_its_bounds(term: Term) -> None:
    sizes = term.sized(Oscillation(inertia=100.0, frequency=70.0, damping_ratio=0.05))
    assert bool(sizes) is (term.role is not Role.NONE)
    for size, p in zip(sizes, term.parameters, strict=False):
        assert p.bounds[0] < size < p.bounds[1]


@pytest.mark.parametrize("term", [t for t in TERMS.values() if t.friction and not t.states], ids=lambda term: term.name)
def test_friction_vanishes_without_motion(term: Term) -> None:
    p = [q.guess or 0.5 for q in term.parameters]
    m = replace(_motion(term, 1.0), v=np.zeros(1), s=np.zeros(1), tau=0.0)
    assert not np.any(term.torque(m, p))
