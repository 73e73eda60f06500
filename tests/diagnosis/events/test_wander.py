"""A torque that wanders by itself is no event, and an event beside one is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.diagnosis.events.bins import BinnedRecord
from robotid.diagnosis.events.shapes import FRICTION, TORQUE, Shape, best_shapes, significance, strength
from robotid.diagnosis.events.wander import beside_wander
from robotid.model.array import Array

BINS = 48
KNOWN = 400.0  # inverse variance of the torque of a bin


def binned(torque: Array, rng: np.random.Generator) -> BinnedRecord:
    """A record whose bins tell of a torque at the motor, (B,), and of a friction of 0, beside noise of unit variance;
    a constant torque is known."""
    product = np.zeros((2, BINS, 2, BINS))
    beyond_mean = np.eye(BINS) - 1.0 / BINS
    product[TORQUE, :, TORQUE] = KNOWN * beyond_mean
    product[FRICTION, range(BINS), FRICTION, range(BINS)] = KNOWN
    moment = np.sqrt(KNOWN) * rng.standard_normal((2, BINS))
    moment[TORQUE] = beyond_mean @ (moment[TORQUE] + KNOWN * torque)
    edges = np.linspace(0.0, 5.0, BINS + 1)
    return BinnedRecord("r", edges, product, moment, np.zeros((2, BINS, 0)), np.full((2, BINS), KNOWN))


def best_step(seen: BinnedRecord) -> Shape:
    steps = [one for one in best_shapes(seen) if one.kind == "step" and one.column == TORQUE]
    return max(steps, key=lambda one: strength(seen, one).energy)


def walk(rng: np.random.Generator, step: float) -> Array:
    return np.asarray(step * np.cumsum(rng.standard_normal(BINS)))


def test_the_largest_step_of_a_random_walk_is_no_event() -> None:
    rng, found = np.random.default_rng(1), list[float]()
    for _ in range(200):
        seen = binned(walk(rng, 0.5), rng)
        found.append(beside_wander(seen, best_step(seen), 2 * BINS))
    assert min(found) > 1e-3


def test_a_drift_of_a_random_walk_is_no_event() -> None:
    rng = np.random.default_rng(4)
    drift = Shape("drift", TORQUE, 0, BINS)
    records = [(binned(walk(rng, 0.5), rng), binned(walk(rng, 0.5), rng)) for _ in range(200)]
    found = np.array([significance(seen, drift, 1, [other])[0] for seen, other in records])
    assert np.mean(found < 0.1) < 0.15
    assert np.mean(found < 0.01) < 0.02
    torque = np.linspace(0.0, 1.0, BINS) + walk(rng, 0.01)
    assert significance(binned(torque, rng), drift, 2 * BINS)[0] < 1e-3


SHAPES = {"bump": Shape("bump", TORQUE, 10, 14), "step": Shape("step", TORQUE, 20, BINS)}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_of_a_fixed_event_the_p_values_are_uniform_at_most(shape: Shape) -> None:
    rng = np.random.default_rng(2)
    makers = (lambda: walk(rng, 0.3), lambda: 0.5 * rng.standard_normal(BINS), lambda: np.zeros(BINS))
    found = np.array([beside_wander(binned(make(), rng), shape, 1) for make in makers for _ in range(100)])
    assert np.mean(found < 0.1) < 0.15
    assert np.mean(found < 0.01) < 0.02


def test_a_jump_beside_small_ones_is_an_event() -> None:
    rng = np.random.default_rng(3)
    torque = walk(rng, 0.05)
    torque[20:] += 2.0
    seen = binned(torque, rng)
    assert best_step(seen).first == 20
    assert beside_wander(seen, best_step(seen), 2 * BINS) < 1e-6


def moving(torque: Array, direction: Array, rng: np.random.Generator) -> BinnedRecord:
    """A record whose bins tell of a torque (B,), and of it alone, of a motor that moves in a direction in each."""
    unit = np.stack([np.ones(BINS), direction])
    product = KNOWN * np.einsum("ai,bj,ij->aibj", unit, unit, np.eye(BINS))
    moment = unit * (KNOWN * torque + np.sqrt(KNOWN) * rng.standard_normal(BINS))
    return replace(binned(torque, rng), product=product, moment=moment)


def test_a_friction_that_jumps_is_an_event_however_large() -> None:
    """A wander of one level is no quieter before it."""
    rng, direction = np.random.default_rng(5), np.where(np.arange(BINS) % 8 < 4, 1.0, -1.0)
    shape = Shape("step", FRICTION, 20, BINS)
    assert beside_wander(moving(np.where(np.arange(BINS) < 20, 0.0, direction), direction, rng), shape, 40) < 1e-6
    assert beside_wander(moving(walk(rng, 0.5), direction, rng), shape, 40) > 1e-3


def test_of_a_record_that_tells_nothing_no_event_is_known() -> None:
    seen = BinnedRecord(
        "r", np.linspace(0.0, 1.0, 5), *(np.zeros(s) for s in ((2, 4, 2, 4), (2, 4), (2, 4, 0), (2, 4)))
    )
    assert beside_wander(seen, Shape("step", TORQUE, 2, 4), 1) == 1.0
