"""What a candidate is said to add, against a simulation with a little of it: before and after what the fit takes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.extended_joint import open_loop, values
from support.paper_joint import STRUCTURE

from robotid.catalogue import assemble
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.refit.refitted_model import Unknowns, segment_fit
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.projection import Projected, project
from robotid.diagnosis.scoring.scan import Scan, scan
from robotid.diagnosis.scoring.score_test import score
from robotid.diagnosis.scoring.term_candidate import TermCandidate
from robotid.estimate.residual import observed
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.term import Motion
from robotid.signals.record import Record
from robotid.simulation.internal_states import simulate_internal_states
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

BASE = STRUCTURE.without("gear.cubic_spring")
SMALL = 1e-4  # rad/s: the change of speed to which amplitudes are set; its square is nothing beside the reversals
CLOSE = 0.015  # of a column's length before projection: forces are means over an interval in which friction reverses
JUMPING = {"gear.backlash": 0.03}
"""Effects that come and go within a sampling interval, so that their means tell less."""


def middle(name: str) -> EffectCandidate:
    """The effect in the middle of its grids."""
    grid = [c for c in candidates(BASE, "speed") if c.name == name]
    return grid[len(grid) // 2]


NAMES = list(dict.fromkeys(c.name for c in candidates(BASE, "speed")))
WITH_MEMORY = [
    n for n in NAMES if isinstance(c := middle(n), TermCandidate) and c.effect.states and "third_mass" not in n
]
AMPLITUDES = [(name, k) for name in NAMES for k in middle(name).scored]


@cache
def base() -> tuple[Record, Trajectory]:
    """Four reversals, a rest at first, and what the joint without anything does."""
    joint, torque = assemble(BASE, angle=True), open_loop(900)
    motion = simulate(joint, values(joint), torque, np.zeros(joint.nx))
    return replace(torque, phi_m=motion.phi_m, dphi_m=motion.dphi_m), motion


def with_effect(c: EffectCandidate, parameter: int, amplitude: float) -> tuple[Joint, Array]:
    """The joint with a candidate of this amplitude."""
    joint, known = assemble(BASE.extended(c.name), angle=True), base()[1]
    own = dict(zip((f"{c.name}.{p.symbol}" for p in c.parameters), c.values, strict=True))
    own[f"{c.name}.{c.parameters[parameter].symbol}"] += amplitude
    return joint, joint.parameters().with_values(dict(zip(known.joint.names, known.theta, strict=True)) | own).values


def simulated(c: EffectCandidate, parameter: int, amplitude: float) -> Array:
    joint, theta = with_effect(c, parameter, amplitude)
    return observed(simulate(joint, theta, base()[0], np.zeros(joint.nx)), "speed")


def scanned(missing: tuple[EffectCandidate, ...]) -> Scan:
    """The record with the columns of all parameters, of all first states, and of candidates; nothing is left over."""
    record, motion = base()
    joint = motion.joint
    states = [k for k in range(joint.nx) if joint.state_names[k] != "phi_m"]
    unknowns = Unknowns("speed", tuple(range(len(joint.names))), tuple(states))
    return scan(segment_fit(Segment(record, UNIT_WHITENING), motion, "speed"), unknowns, missing)


def beside(one: Scan, residual: Array) -> Projected:
    """Columns and a residual as the search sees them, unwhitened."""
    return project([replace(one, signals=np.concatenate([one.signals[:-1], residual[None]]))])


@pytest.mark.parametrize(("name", "parameter"), AMPLITUDES)
def test_a_column_is_what_a_little_of_the_effect_changes(name: str, parameter: int) -> None:
    c = middle(name)
    one = scanned((c,))
    column = one.signals[one.known + c.scored.index(parameter)]
    little = SMALL / np.abs(column).max()
    change = (simulated(c, parameter, little) - simulated(c, parameter, 0.0)) / little
    close = JUMPING.get(name, CLOSE) * np.linalg.norm(column)
    assert np.linalg.norm(change - column) <= close
    seen = beside(one, change)
    left = seen.missing[:, c.scored.index(parameter)]
    assert np.linalg.norm(seen.residual - left) <= close


def test_first_states_and_parameters_are_taken_out() -> None:
    """A column less its regression on all that was fitted is what projection leaves of it."""
    c = middle("motor.cogging")
    one = scanned((c,))
    known, column = one.signals[: one.known], one.signals[one.known]
    scaled = known / np.linalg.norm(known, axis=1, keepdims=True)
    explained = np.linalg.lstsq(scaled.T, column, rcond=None)[0] @ scaled
    left = beside(one, np.zeros(len(column))).missing[:, 0]
    assert np.linalg.norm(left) == pytest.approx(np.linalg.norm(column - explained), rel=1e-6)
    assert np.linalg.norm(left) < 0.9 * np.linalg.norm(column)


def test_what_the_fit_can_take_over_is_not_scored() -> None:
    """A gain of the torque scales every parameter alike: no record shows it."""
    c = middle("torque.torque_gain")
    rng = np.random.default_rng(1)
    one = scanned((c,))
    (found,) = score(beside(one, rng.standard_normal(len(one.segment.record))), (c,))
    assert found.energy == 0.0


def test_a_one_sided_effect_is_not_scored_on_its_forbidden_side() -> None:
    c = middle("gear.backlash")
    one = scanned((c,))
    column = one.signals[one.known]
    (right,) = score(beside(one, 1e-5 * column), (c,))
    (wrong,) = score(beside(one, -1e-5 * column), (c,))
    assert right.amplitude == pytest.approx((1e-5,))
    assert wrong.energy == 0.0


@pytest.mark.parametrize("name", WITH_MEMORY)
def test_memory_follows_the_motion_as_it_does_in_a_simulation(name: str) -> None:
    """Along the motion of a joint that has the effect, the memory by itself is that of the whole simulation."""
    c = middle(name)
    assert isinstance(c, TermCandidate)
    joint, theta = with_effect(c, c.scored[0], 1e-9)
    record = base()[0]
    truth = simulate(joint, theta, record, np.zeros(joint.nx))
    (place,) = [p for p in joint.placed if p.term.name == c.effect.name]
    s = np.sign(truth.x[joint.speeds])
    (m,) = [
        m for p, m in zip(joint.placed, joint.motions(truth.x, None, s, record.t, theta), strict=True) if p is place
    ]
    own = Motion(m.x, m.v, m.a, m.s, m.t, 0.0 * truth.x[place.z], m.tau, m.xw, m.vw)
    found = simulate_internal_states(c.effect, own, theta[place.at].tolist(), record.sampling_time)
    expected = truth.x[place.z]
    assert np.abs(expected).max() > 0.0
    # order 2 in time, and of order 1 where the motion turns round: a per cent of the swing at 0.5 ms
    assert np.sqrt(np.mean((found - expected) ** 2)) <= 0.01 * np.abs(expected).max()
