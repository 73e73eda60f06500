"""Linearised steps: in parts as at once, of one length as of many, and across kinks as in steps that end there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.paper_joint import RATIO, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.model.derivatives import DerivativeColumns
from robotid.model.structure import Structure
from robotid.signals.torque_steps import TorqueSteps
from robotid.simulation.friction import crossing, regular_step
from robotid.simulation.friction.crossing import linearise_steps
from robotid.simulation.friction.step import StepInputs, Steps

H = 5e-4


def inputs(h: Array | float = H) -> tuple[StepInputs, Array, Array]:
    """Forty steps of the paper's joint, reversals among them, at nodes that are no simulation."""
    joint = assemble(STRUCTURE)
    theta = joint.parameters().with_values(TRUTH).values
    rng, t = np.random.default_rng(3), np.arange(41) * H
    x = np.stack([2e-4 * np.sin(40 * t), 0.4 * np.sin(300 * t + 0.1), 0.4 * RATIO * np.sin(300 * t)])
    steps = StepInputs(joint, theta, rng.standard_normal(40), t[:-1], h, DerivativeColumns(tuple(range(7))))
    return steps, x[:, :-1], x[:, 1:]


def assert_alike(found: Steps, expected: Steps) -> None:
    assert found.S is not None
    assert expected.S is not None
    for one, other in ((found.G, expected.G), (found.c, expected.c), (found.S, expected.S), (found.end, expected.end)):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12 * np.abs(other).max())


def test_steps_in_parts_are_those_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    at_once = linearise_steps(*inputs())
    monkeypatch.setattr(crossing, "BLOCK_ENTRIES", 45 * 7)
    assert_alike(linearise_steps(*inputs()), at_once)


def test_few_steps_are_those_of_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """By whole matrices, and entry by entry."""
    few = linearise_steps(*inputs())
    monkeypatch.setattr(regular_step, "FEW", 0)
    assert_alike(linearise_steps(*inputs()), few)


def test_one_length_for_all_is_that_length_for_each() -> None:
    assert_alike(linearise_steps(*inputs()), linearise_steps(*inputs(np.full(40, H))))


@pytest.mark.parametrize("share", [0.03, 0.37, 0.9])
def test_a_reversal_is_where_the_speed_vanishes(share: float) -> None:
    """A free motor that brakes: the instant of its reversal, and all that follows, are known in closed form."""
    joint = assemble(Structure(("motor.inertia", "motor.coulomb")))
    J, Fc, u = 0.01, 0.5, -2.0
    braking, after = (u - Fc) / J, (u + Fc) / J
    v0 = -braking * share * H
    steps = linearise_steps(
        StepInputs(joint, np.array([J, Fc]), np.array([u]), np.zeros(1), H), np.array([[v0]]), np.array([[v0]])
    )
    assert v0 + steps.c[0, 0] == pytest.approx(after * (1.0 - share) * H, rel=1e-9)
    assert steps.G[0, 0, 0] == pytest.approx(after / braking, rel=1e-9)  # a faster start reverses later


def test_what_starts_from_rest_and_stops_on_the_way_stays_where_it_stops() -> None:
    """A twisted spring moves the motor until its friction holds it again: half a swing, known in closed form."""
    joint = assemble(Structure(("motor.inertia", "motor.coulomb", "gear.spring", "arm.inertia"), gear_ratio=1.0))
    half_swing = 0.9 * H
    J, Fc, k = 0.01, 0.5, 0.01 * (np.pi / half_swing) ** 2
    theta = joint.parameters().with_values(
        {"motor.inertia.J": J, "motor.coulomb.Fc": Fc, "gear.spring.k1": k, "arm.inertia.J": 1e9}
    )
    before, way = 1.2 * Fc, 2.0 * 0.2 * Fc / k
    x0 = np.array([[-before / k], [0.0], [0.0]])
    steps, end = StepInputs(joint, theta.values, np.zeros(1), np.zeros(1), H), x0.copy()
    for _ in range(5):
        found = linearise_steps(steps, x0, end)
        end = end + found.c
    assert end[1, 0] == 0.0
    assert end[0, 0] - x0[0, 0] == pytest.approx(way, rel=0.2)  # one step of order 4 over half a swing
    assert np.all(found.G[1] == 0.0)


def test_a_torque_that_changes_on_the_way_is_two_steps_in_a_row() -> None:
    """Settled nodes and derivatives are those of a grid that has a node at every change."""
    whole, x0, x1 = inputs()
    share = np.where(np.arange(40) % 3, np.linspace(0.1, 0.9, 40), 0.5)
    steps = TorqueSteps(share, np.where(np.arange(40) % 3, 0.8, 0.0))
    found = linearise_steps(replace(whole, torque_steps=steps), x0, x1)
    first, then = steps.around(whole.u)
    before = replace(whole.with_duration(share * H, whole.t), u=first)
    after = replace(whole.with_duration((1 - share) * H, whole.t + share * H), u=then)
    middle = x0 + share * (x1 - x0)
    for _ in range(5):
        middle = middle + linearise_steps(before, x0, middle).c
    one, other = linearise_steps(before, x0, middle), linearise_steps(after, middle, x1)
    assert one.S is not None
    assert other.S is not None
    assert found.S is not None
    G = np.einsum("ijn,jkn->ikn", other.G, one.G)
    S = np.einsum("ijn,jkn->ikn", other.G, one.S) + other.S
    changes = np.flatnonzero(steps.step)
    for part, expected in ((found.c, other.c), (found.G, G), (found.S, S)):
        wanted = expected[..., changes]
        np.testing.assert_allclose(part[..., changes], wanted, rtol=1e-7, atol=1e-10 * np.abs(wanted).max())
    same, rest = linearise_steps(whole, x0, x1), np.flatnonzero(steps.step == 0.0)
    np.testing.assert_allclose(found.c[:, rest], same.c[:, rest], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("share", [0.2, 0.7])
def test_a_reversal_follows_a_torque_that_changes_within_the_interval(share: float) -> None:
    """A free motor that is braked from that share of the interval on, in closed form."""
    joint = assemble(Structure(("motor.inertia", "motor.coulomb")))
    J, Fc, u, step = 0.01, 0.5, -2.0, -4.0
    steps = TorqueSteps(np.array([share]), np.array([step]))
    before, after = ((float(one[0]) - Fc) / J for one in steps.around(np.array([u])))
    left = (1.0 - share) * H
    v0 = -after * 0.5 * left - before * share * H
    made = StepInputs(joint, np.array([J, Fc]), np.array([u]), np.zeros(1), H, torque_steps=steps)
    found = linearise_steps(made, np.array([[v0]]), np.array([[v0]]))
    assert v0 + found.c[0, 0] == pytest.approx((after * J + 2 * Fc) / J * 0.5 * left, rel=1e-9)
