"""What every effect, term or channel, says about itself is complete."""

from __future__ import annotations

import re
from importlib import import_module
from math import isfinite

import pytest

from robotid.channels import CHANNELS
from robotid.model.channel import Channel
from robotid.model.describe import describe
from robotid.model.port import Port, Signal
from robotid.model.term import Term
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
