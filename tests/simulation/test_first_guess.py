"""The guess of a trajectory decides how long a simulation takes, never what comes of it."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from support.extended_joint import open_loop, values
from support.paper_joint import STRUCTURE

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.fallback.lsoda import lsoda
from robotid.simulation.first_guess import initial_state, measured_guess
from robotid.simulation.newton.problem import Problem
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

RECORD = open_loop(800)
UNDAMPED = STRUCTURE.without("gear.cubic_spring").without("gear.damper")
SAME = 1e-5  # rad/s: the solver's own tolerance, at speeds of 40 rad/s


def joint_of(structure: Structure) -> tuple[Joint, Array, Trajectory]:
    """A joint, its parameters, and its motion from rest."""
    joint = assemble(structure, angle=True)
    theta = values(joint)
    return joint, theta, simulate(joint, theta, RECORD, np.zeros(joint.nx))


@pytest.mark.parametrize("structure", [STRUCTURE, UNDAMPED], ids=["damped", "undamped"])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e4, 1e8], ids=str)
def test_a_wild_guess_leads_to_the_same_motion(wrong: float, structure: Structure) -> None:
    """As a step of the fit makes one where the derivatives are large: without damping they grow along the record."""
    joint, theta, known = joint_of(structure)
    guess = known.x.copy()
    guess[:, 500:] = wrong * known.x.max(axis=1, keepdims=True)
    found = simulate(joint, theta, RECORD, np.zeros(joint.nx), guess)
    assert found.dphi_m == pytest.approx(known.dphi_m, abs=SAME)
    assert found.twist == pytest.approx(known.twist, abs=SAME * float(np.abs(known.x[0]).max()))


@pytest.mark.parametrize("effect", ["motor.presliding", "arm.coulomb", "arm.third_mass"])
def test_a_first_state_is_that_of_the_measured_motion(effect: str) -> None:
    joint = assemble(STRUCTURE.extended(effect), angle=True)
    angle = 0.3 + np.sin(6.0 * RECORD.t)
    moving = Record.from_arrays(RECORD.tau_m, angle, RECORD.sampling_time)
    guess = measured_guess(joint, values(joint), moving)
    assert np.abs(guess[:, 0]).max() > 0
    np.testing.assert_array_equal(initial_state(joint, values(joint), moving), guess[:, 0])


def test_a_simulation_leaves_nothing_of_its_guess_behind() -> None:
    joint, theta, known = joint_of(STRUCTURE)
    guess = known.x.copy()
    left = weakref.ref(guess)
    gc.disable()  # arrays as large as records must not wait for a collection
    try:
        simulate(joint, theta, RECORD, np.zeros(joint.nx), guess)
        del guess
        assert left() is None
    finally:
        gc.enable()


@pytest.mark.parametrize("wrong", [np.nan, np.inf], ids=str)
def test_a_first_state_that_is_no_number_is_told(wrong: float) -> None:
    joint, theta, known = joint_of(UNDAMPED)
    start = np.zeros(joint.nx)
    start[0] = wrong
    with pytest.raises(NumericsError, match="first state is not finite"):
        simulate(joint, theta, RECORD, start, known.x)


def test_a_motion_that_runs_away_is_told_in_one_line_without_warnings() -> None:
    """Friction that drives with the square of the speed reaches any speed in finite time."""
    joint = assemble(Structure(("motor.inertia", "motor.quadratic_friction")))
    theta = joint.parameters().with_values({"motor.inertia.J": 0.01, "motor.quadratic_friction.Fq": -1.0}).values
    problem = Problem(joint, theta, np.zeros(100), RECORD.sampling_time, np.ones((1, 101)))
    with pytest.raises(NumericsError, match=r"the simulation diverges at t = 0\.0[01]"):
        lsoda(problem, 0, 100, np.array([1.0]))
