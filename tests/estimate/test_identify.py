"""The start of a fit: what is known goes before what the initialisations find, and that before what is declared."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.small_bench import AXIS, TRUTH, records

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate.identify import StartOptions, initialise_flexible, initialise_rigid, starting_parameters
from robotid.model.parameters import KnownParameter

JOINT = assemble(AXIS)
J, FV, FC = JOINT.names
FOUND = {J: 0.011, FV: 0.012}


def test_what_is_known_goes_before_what_was_found() -> None:
    start = starting_parameters(JOINT, {J: KnownParameter(guess=0.02)}, FOUND)
    assert (start[J], start[FV], start[FC]) == (0.02, 0.012, JOINT.parameters()[FC])
    assert start.free.all()


def test_a_parameter_fixed_without_a_guess_keeps_what_was_found() -> None:
    start = starting_parameters(JOINT, {J: KnownParameter(fixed=True)}, FOUND, [FC])
    assert (start[J], start.free.tolist()) == (0.011, [False, True, False])


def test_a_shape_that_says_which_law_it_is_is_not_estimated() -> None:
    joint = assemble(AXIS.extended("motor.pose_inertia[q2]"))
    start = starting_parameters(joint, {"motor.pose_inertia[q2].n": KnownParameter(guess=2.0)}, FOUND)
    estimated = dict(zip(start.names, start.free.tolist(), strict=True))
    assert estimated == dict.fromkeys(joint.names, True) | {"motor.pose_inertia[q2].n": False}


def test_a_start_lies_within_its_bounds() -> None:
    assert starting_parameters(JOINT, {J: KnownParameter(bounds=(0.015, 1.0))}, FOUND)[J] == 0.015


def test_steps_read_the_records_that_serve_them() -> None:
    slow, wide, check = records({}, quiet=True)
    serving = [replace(slow, use="flex"), replace(wide, use="rigid"), check]
    rigid = initialise_rigid(AXIS, {}, serving, StartOptions())
    assert list(rigid.torque_error_percent) == ["wide"]
    assert rigid.guesses[J] == pytest.approx(TRUTH[J], rel=0.05)
    assert initialise_flexible(AXIS, {}, serving, rigid, StartOptions()).frfs == ()
    with pytest.raises(NumericsError, match="no record serves the rigid initialisation"):
        initialise_rigid(AXIS, {}, [serving[0], check], StartOptions())
