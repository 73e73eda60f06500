"""The column of a missing effect, from the joint as it is, against that of the joint which has it at its null."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.extended_joint import TERMS_IN_PLACE, TORQUE_CHANNELS, open_loop, structure_with, values
from support.extended_joint import kind_of as kind

from robotid.catalogue import assemble
from robotid.diagnosis.refit.refitted_model import Unknowns
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.catalogue_candidates import channel_candidate, term_candidate
from robotid.diagnosis.scoring.columns import columns
from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.joint import Joint
from robotid.model.port import Port, Signal
from robotid.model.structure import Structure
from robotid.model.term import MotionTransform, Term
from robotid.simulation.sensitivities import sensitivities
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

RECORD = open_loop(1500)
CRUDE = {"backlash": 0.05, "stribeck": 0.07, "presliding": 0.05, "temperature_friction[temperature]": 0.02}
"""Relative error of columns that jump at reversals, or inside them: forces are means of an interval's ends."""


VANISHING = [e for e in (*TERMS_IN_PLACE, *TORQUE_CHANNELS) if any(p.null is not None for p in kind(e).parameters)]
WITH_SHAPES = [(e, k) for e in VANISHING for k in ((0, -1) if any(p.is_shape for p in kind(e).parameters) else (0,))]
LEANING = [e for e in VANISHING if isinstance(kind(e), MotionTransform | Channel) or getattr(kind(e), "reads", None)]


def candidate(effect: str, shape: int) -> EffectCandidate:
    """An effect at its null, with the first (0) or last (-1) shapes of its grids."""
    place, found = effect.split(".")[0], kind(effect)
    at = [p.grid[shape] if p.is_shape else p.guess if p.null is None else p.null for p in found.parameters]
    if isinstance(found, Term):
        return term_candidate(Port(place), found, tuple(at))
    return channel_candidate(Signal(place), found, tuple(at))


@cache
def motion(structure: Structure) -> Trajectory:
    joint = assemble(structure)
    return simulate(joint, values(joint), RECORD, x0=np.zeros(joint.nx))


def extended(c: EffectCandidate) -> tuple[Joint, Array, list[int]]:
    """The joint with the candidate, its parameters with the candidate at its null, and which of them are scored."""
    joint = assemble(structure_with(c.name))
    symbols = [f"{c.name}.{p.symbol}" for p in c.parameters]
    theta = values(joint, **dict(zip(symbols, c.values, strict=True)))
    return joint, theta, [joint.names.index(symbols[k]) for k in c.scored]


@pytest.mark.parametrize(("effect", "shape"), WITH_SHAPES)
def test_column_is_that_of_the_joint_with_the_effect_at_its_null(effect: str, shape: int) -> None:
    c = candidate(effect, shape)
    without = motion(structure_with(effect).without(effect))
    found = columns(without, replace(RECORD, phi_m=without.phi_m), Unknowns("speed"), (c,)).candidates
    joint, theta, scored = extended(c)
    trajectory = simulate(joint, theta, RECORD, np.zeros(joint.nx), without.x if joint.nx == len(without.x) else None)
    assert trajectory.dphi_m == pytest.approx(without.dphi_m, abs=1e-5)
    expected = sensitivities(trajectory, RECORD, scored, (joint.motor_speed,))[0]
    for one, other in zip(found, expected, strict=True):
        assert np.linalg.norm(other) > 0
        assert np.linalg.norm(one - other) <= CRUDE.get(effect.partition(".")[2], 0.01) * np.linalg.norm(other)


@pytest.mark.parametrize("effect", LEANING)
def test_column_tells_what_a_little_of_the_effect_does(effect: str) -> None:
    c = candidate(effect, -1)
    without = motion(structure_with(effect).without(effect))
    found = columns(without, replace(RECORD, phi_m=without.phi_m), Unknowns("speed"), (c,)).candidates
    joint, theta, scored = extended(c)
    start = np.zeros(joint.nx)
    base = simulate(joint, theta, RECORD, start)
    for column, k in zip(found, scored, strict=True):
        little = 1e-4 / np.abs(column).max() * (np.arange(len(theta)) == k)
        change = simulate(joint, theta + little, RECORD, start, base.x).dphi_m - base.dphi_m
        assert np.linalg.norm(change / little[k] - column) <= 0.15 * np.linalg.norm(column)
