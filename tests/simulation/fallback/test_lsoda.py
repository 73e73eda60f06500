"""The fallback: what LSODA integrates agrees with Newton's method, and is remembered."""

from __future__ import annotations

import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate import residual
from robotid.estimate.least_squares import linearise
from robotid.estimate.residual import TRIAL_PATIENCE, OutputError
from robotid.interrupt import Interrupted, interruptible
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.port import Port
from robotid.signals.record import Record
from robotid.simulation.fallback import lsoda as fallback
from robotid.simulation.newton import solver
from robotid.simulation.newton.problem import Problem, WindowProblem
from robotid.simulation.newton.solver import Course, NewtonResult
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory
from robotid.terms import TERMS

JOINT = assemble(STRUCTURE)
THETA = JOINT.parameters().with_values(TRUTH).values
T = np.arange(200) * SAMPLING_TIME
RECORD = Record("r", "estimate", "both", SAMPLING_TIME, 2.0 + np.sin(40 * T), 0 * T, 5.0 + 0 * T)
START = np.array([1e-4, 5.0, 5.0 * JOINT.ratio])


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ROBOTID_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def refuse(first_one: int, last_one: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton's method refuses every window that touches these samples."""
    works = solver.newton

    def stubborn(problem: WindowProblem, first: int, start: Array, guess: Array, scale: Array) -> Course[NewtonResult]:
        if first < last_one and first + guess.shape[1] - 1 > first_one:
            return NewtonResult(guess, 0, 1)
        return (yield from works(problem, first, start, guess, scale))

    monkeypatch.setattr(solver, "newton", stubborn)


@pytest.fixture
def newton_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    refuse(80, 90, monkeypatch)


@pytest.mark.usefixtures("newton_fails")
def test_a_stretch_by_lsoda_agrees_with_newton(monkeypatch: pytest.MonkeyPatch) -> None:
    by_lsoda = simulate(JOINT, THETA, RECORD, START)
    assert by_lsoda.fallback_windows
    monkeypatch.undo()
    plain = simulate(JOINT, THETA, RECORD, START)
    assert plain.fallback_windows == ()
    assert by_lsoda.dphi_m == pytest.approx(plain.dphi_m, abs=2e-5)


@pytest.mark.usefixtures("newton_fails")
def test_a_simulation_is_allowed_as_many_failed_windows_as_it_needed() -> None:
    needed = simulate(JOINT, THETA, RECORD, START).failed_windows
    assert needed > 0
    assert simulate(JOINT, THETA, RECORD, START, max_failed_windows=needed).failed_windows == needed
    with pytest.raises(NumericsError, match="settles too slowly"):
        simulate(JOINT, THETA, RECORD, START, max_failed_windows=needed - 1)


@pytest.mark.parametrize(("needed", "allowed"), [(0, TRIAL_PATIENCE), (TRIAL_PATIENCE + 5, TRIAL_PATIENCE + 5)])
def test_a_trial_may_need_as_many_as_the_point_beside_it(
    needed: int, allowed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = OutputError(JOINT, JOINT.parameters().with_values(TRUTH), (RECORD,), "speed", np.ones(1))
    plain, asked = simulate(JOINT, THETA, RECORD, START), list[int | None]()

    def simulated(joint: Joint, theta: Array, records: object, starts: object, limit: int | None) -> list[Trajectory]:
        asked.append(limit)
        return [replace(plain, failed_windows=needed)]

    monkeypatch.setattr(residual, "simulate_together", simulated)
    at = linearise(problem, problem.evaluate(problem.start()), [None])
    problem.evaluate(problem.start(), at)
    problem.evaluate(problem.start(), trial=True)
    replace(problem, max_failed_windows=2).evaluate(problem.start(), at)
    assert asked == [None, allowed, TRIAL_PATIENCE, 2]


def test_a_motion_much_faster_than_its_samples_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A motor of hardly any inertia on a hard spring: LSODA would follow millions of oscillations."""
    light = TRUTH | {"motor.inertia.J": 1e-9, "arm.inertia.J": 3e-5, "gear.spring.k1": 1e9, "gear.damper.d": 0.0}
    monkeypatch.setattr(fallback, "cached", lambda key, shape, make: make())
    theta = JOINT.parameters().with_values(light).values
    problem = Problem(JOINT, theta, RECORD.tau_m, SAMPLING_TIME, np.zeros((3, len(T))))
    with pytest.raises(NumericsError, match="much faster than it is sampled"):
        fallback.lsoda(problem, 0, 8, START)


def test_what_dies_out_within_an_interval_may_take_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """A light, stiff arm comes to rest beside a motor that sticks: hundreds of steps in one interval, few after."""
    stiff = TRUTH | {"gear.spring.k1": 1.7e4, "gear.damper.d": 1000.0, "arm.inertia.J": 0.02}
    monkeypatch.setattr(fallback, "cached", lambda key, shape, make: make())
    monkeypatch.setattr(fallback, "MAX_STEPS", 100)
    theta = JOINT.parameters().with_values(stiff).values
    problem = Problem(JOINT, theta, np.full(8, 0.08), 0.004, np.zeros((3, 9)))
    nodes = fallback.lsoda(problem, 0, 8, np.array([1e-5, 0.0, 0.17]))
    assert np.abs(nodes[2, 1:]).max() < 1e-3
    with pytest.raises(NumericsError, match="much faster than it is sampled"):
        fallback.lsoda(problem, 0, 1, np.array([1e-5, 0.0, 0.17]))


def test_a_reversal_by_lsoda_agrees_with_newton(monkeypatch: pytest.MonkeyPatch) -> None:
    back = replace(RECORD, tau_m=-3.5 + 0 * T, dphi_m=0 * T)
    plain = simulate(JOINT, THETA, back, START)
    turn = int(np.argmax(plain.dphi_m <= 0.0))
    assert turn > 5
    assert plain.dphi_m[-1] < -1.0
    refuse(turn - 5, turn + 5, monkeypatch)
    by_lsoda = simulate(JOINT, THETA, back, START)
    assert by_lsoda.fallback_windows
    assert by_lsoda.dphi_m == pytest.approx(plain.dphi_m, abs=1e-4)


@pytest.mark.usefixtures("newton_fails")
def test_the_same_question_is_answered_from_the_cache(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = simulate(JOINT, THETA, RECORD, START)
    assert list(cache.glob("*.npy"))
    monkeypatch.setattr(fallback, "_integrate", None)  # whoever integrates again fails
    assert np.array_equal(simulate(JOINT, THETA, RECORD, START).x, first.x)


@pytest.mark.usefixtures("newton_fails")
def test_another_parameter_is_another_question(monkeypatch: pytest.MonkeyPatch) -> None:
    simulate(JOINT, THETA, RECORD, START)
    monkeypatch.setattr(fallback, "_integrate", None)
    with pytest.raises(TypeError):
        simulate(JOINT, THETA * 1.0001, RECORD, START)


@pytest.mark.usefixtures("newton_fails")
def test_a_damaged_or_deleted_cache_only_costs_time(cache: Path) -> None:
    first = simulate(JOINT, THETA, RECORD, START)
    for junk in (b"not an array", b""):
        for file in cache.glob("*.npy"):
            file.write_bytes(junk)
        assert np.array_equal(simulate(JOINT, THETA, RECORD, START).x, first.x)
    for file in cache.glob("*"):
        file.unlink()
    cache.rmdir()
    assert np.array_equal(simulate(JOINT, THETA, RECORD, START).x, first.x)


@pytest.mark.usefixtures("newton_fails")
def test_another_formula_is_another_question(monkeypatch: pytest.MonkeyPatch) -> None:
    simulate(JOINT, THETA, RECORD, START)
    monkeypatch.setattr(fallback, "_integrate", None)
    monkeypatch.setattr(fallback, "_source", lambda term: f"{term} as edited")
    with pytest.raises(TypeError):
        simulate(JOINT, THETA, RECORD, START)


@pytest.mark.usefixtures("newton_fails")
def test_the_answer_for_a_term_without_a_name_is_not_kept(cache: Path) -> None:
    nameless = JOINT.with_more(terms=[(Port.MOTOR, TERMS["constant_torque"])])
    simulate(nameless, np.append(THETA, 0.1), RECORD, START)
    assert not list(cache.glob("*"))


def test_divergence_is_reported_in_words() -> None:
    unstable = JOINT.parameters().with_values({**TRUTH, "gear.spring.k1": -1e10, "gear.cubic_spring.k3": 0.0}).values
    with pytest.raises(NumericsError, match="the simulation diverges"):
        simulate(JOINT, unstable, RECORD, START)


def test_a_signal_is_seen_between_two_of_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = list[float]()

    def rate(joint: Joint, x: Array, u: float, t: float, theta: Array) -> Array:
        calls.append(t)
        if len(calls) == 1:
            signal.raise_signal(signal.SIGTERM)
        return 1e6 * np.cos(1e6 * t) * np.ones_like(x)

    monkeypatch.setattr(fallback, "smooth_rate", rate)
    problem = Problem(JOINT, THETA, RECORD.tau_m[:-1], SAMPLING_TIME, np.zeros((JOINT.nx, len(T))))
    with interruptible(), pytest.raises(Interrupted):
        fallback.lsoda(problem, 0, 1, START)
    assert len(calls) < 50  # of thousands
