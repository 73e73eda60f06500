"""What is known of parameters beforehand, laid over what the effects declare."""

from __future__ import annotations

import pytest

from robotid.catalogue import assemble
from robotid.model.parameters import KnownParameter
from robotid.model.structure import Structure

DECLARED = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))).parameters()
J, FV, FC = DECLARED.names


def test_a_guess_leaves_a_parameter_free() -> None:
    known = DECLARED.with_known({J: KnownParameter(guess=0.02)})
    assert (known[J], known.free.tolist()) == (0.02, [True, True, True])
    assert known[FV] == DECLARED[FV]


def test_only_what_is_fixed_at_a_guess_is_not_free() -> None:
    known = DECLARED.with_known({J: KnownParameter(guess=0.02, fixed=True), FC: KnownParameter(fixed=True)})
    assert known.free.tolist() == [False, True, True]


def test_bounds_replace_those_declared() -> None:
    known = DECLARED.with_known({FC: KnownParameter(bounds=(0.1, 0.9))})
    assert (known.lower[2], known.upper[2]) == (0.1, 0.9)
    assert known.lower[:2].tolist() == DECLARED.lower[:2].tolist()


def test_the_declaration_stays_as_it_was() -> None:
    before = DECLARED.values.copy()
    DECLARED.with_known({J: KnownParameter(guess=0.5, bounds=(0.1, 1.0), fixed=True)})
    assert DECLARED.values.tolist() == before.tolist()


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(KeyError, match=r"motor\.inertia\.I"):
        DECLARED.with_known({"motor.inertia.I": KnownParameter(1.0)})
