"""The linear part of a joint's torques, summed up once, against the same torques evaluated term by term."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.paper_joint import RATIO, STRUCTURE

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.companion import Course
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.model.linear_part import LinearPart, linear_part
from robotid.model.structure import Structure

N = 7


def unfolded(joint: Joint) -> LinearPart:
    """Nothing summed up: every place is evaluated."""
    nv = joint.masses
    none = (False,) * len(joint.placed)
    return LinearPart([{} for _ in range(nv)], np.zeros((nv, nv)), none, joint.placed, None, True)


def point(joint: Joint) -> tuple[Array, Array, Array, Array]:
    rng = np.random.default_rng(4)
    x, u = rng.standard_normal((joint.nx, N)), rng.standard_normal(N)
    t = np.arange(N) * 1e-3
    return x, u, joint.directions(x, np.sign(x[joint.speeds]), t, joint.parameters().values), t


@pytest.mark.parametrize(
    "more",
    [
        (),
        ("motor.stribeck",),
        ("gear.hysteresis",),
        ("gear.backlash",),
        ("link.spring", "link.damper", "tool.inertia"),
        ("motor.load_friction",),
    ],
)
@pytest.mark.parametrize("sticks", [False, True])
def test_right_hand_side_and_derivatives_are_those_of_all_terms(more: tuple[str, ...], sticks: bool) -> None:
    joint = assemble(Structure((*STRUCTURE.effects, *more), gear_ratio=RATIO))
    theta = joint.parameters().values
    x, u, s, t = point(joint)
    sticking = np.zeros((joint.masses, N), dtype=bool)
    sticking[0, ::2] = sticks
    columns = DerivativeColumns(tuple(range(joint.n_theta)), (0, 1))
    whole = joint.evaluate(x, u, s, t, theta, sticking if sticks else None, columns, unfolded(joint))
    found = joint.evaluate(x, u, s, t, theta, sticking if sticks else None, columns)
    bare = joint.evaluate(x, u, s, t, theta, sticking if sticks else None)
    for one in (found, bare):
        np.testing.assert_allclose(one.f, whole.f, rtol=1e-9, atol=1e-9 * np.abs(whole.f).max())
        np.testing.assert_allclose(one.A, whole.A, rtol=1e-9, atol=1e-9 * np.abs(whole.A).max())
    assert found.B is not None
    assert whole.B is not None
    np.testing.assert_allclose(found.B, whole.B, rtol=1e-9, atol=1e-9 * np.abs(whole.B).max())
    assert bare.B is None


def test_linear_terms_are_folded_unless_something_comes_between() -> None:
    plain = assemble(STRUCTURE)
    part = linear_part(plain, plain.parameters().values)
    assert [p.term.name for p in part.others] == ["coulomb", "cubic_spring"]
    assert part.gain is not None
    assert part.diagonal
    behind = assemble(STRUCTURE.extended("gear.backlash"))
    others = {p.term.name for p in linear_part(behind, behind.parameters().values).others}
    assert others == {"coulomb", "cubic_spring", "backlash", "spring", "damper"}


def test_a_joint_without_mass_is_one_clear_error() -> None:
    joint = assemble(Structure(("motor.inertia", "motor.viscous")))
    with pytest.raises(NumericsError, match="a mass of the joint vanishes"):
        linear_part(joint, np.zeros(2))


def test_the_force_is_that_of_all_terms() -> None:
    joint = assemble(STRUCTURE.extended("gear.backlash"))
    theta = joint.parameters().values
    x, u, s, t = point(joint)
    found, whole = (joint.force(x, u, s, t, theta, part) for part in (linear_part(joint, theta), None))
    np.testing.assert_allclose(found, whole, rtol=1e-12, atol=1e-12 * np.abs(whole).max())


@pytest.mark.parametrize("sticks", [False, True])
def test_a_changing_mass_that_couples_nothing_is_inverted_entry_by_entry(sticks: bool) -> None:
    joint = assemble(STRUCTURE.extended("arm.pose_lever[q2]"))
    joint.companions = {"q2": Course(np.random.default_rng(1).normal(size=(3, N)), sampling_time=1e-3)}
    theta = joint.parameters().with_values({"arm.inertia.J": 790.0, "arm.pose_lever[q2].A": 200.0}).values
    x, u, s, t = point(joint)
    sticking = np.zeros((joint.masses, N), dtype=bool)
    sticking[0, ::2] = sticks
    part = linear_part(joint, theta)
    assert part.gain is None
    found, whole = (
        joint.evaluate(x, u, s, t, theta, sticking if sticks else None, None, one)
        for one in (part, replace(part, diagonal=False))
    )
    np.testing.assert_array_equal(found.f, whole.f)
    np.testing.assert_array_equal(found.A, whole.A)
    assert np.all(found.f[joint.motor_speed, ::2] == 0.0) == sticks
