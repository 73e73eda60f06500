"""Windows of Newton's method: how they grow, and when a simulation is given up."""

from __future__ import annotations

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.simulation.newton.problem import Problem
from robotid.simulation.newton.solver import MIN_WINDOW, followed, integrate, newton, state_scale

JOINT = assemble(STRUCTURE)
THETA = JOINT.parameters().with_values(TRUTH).values
N = 600
U = 2.0 * np.sin(2 * np.pi * 5 * np.arange(N) * SAMPLING_TIME)


def never(first: int, stop: int, start: Array) -> Array:
    raise AssertionError(f"Newton's method fails at samples {first} to {stop}")


def problem(guess: Array | None = None, **settings: int) -> Problem:
    near = np.zeros((JOINT.nx, N + 1)) if guess is None else guess
    return Problem(JOINT, THETA, U, SAMPLING_TIME, near, **settings)


def test_one_window_settles_at_the_trajectory_from_any_first_guess() -> None:
    x = integrate(problem(), np.zeros(JOINT.nx), never)
    found = followed(newton(problem(x), 0, x[:, 0], x, state_scale(x)))
    assert found.settled == N
    assert found.iterations == 1
    assert found.x == pytest.approx(x, abs=1e-6 * np.abs(x).max())


def test_a_problem_stays_as_it_is() -> None:
    """The size of the trajectory so far is the solver's own."""
    one = problem()
    guess = one.guess.copy()
    first, again = (integrate(one, np.zeros(JOINT.nx), never) for _ in range(2))
    assert np.array_equal(first, again)
    assert np.array_equal(one.guess, guess)


def test_a_simulation_is_given_up_once_too_many_windows_fail() -> None:
    far = np.zeros((JOINT.nx, N + 1))
    far[JOINT.motor_speed] = 1e3 * (-1.0) ** np.arange(N + 1)
    with pytest.raises(NumericsError, match="too slowly"):
        integrate(problem(far, max_failed_windows=0), np.zeros(JOINT.nx), never)


class Slow(Problem):
    """Every Newton step goes less than the whole way, so that no window is quick."""

    def linearise(self, first: int, last: int, x: Array):  # type: ignore[no-untyped-def]
        steps = Problem.linearise(self, first, last, x)
        steps.c[:] *= 0.7
        return steps


def test_a_simulation_is_given_up_once_its_windows_are_slow_though_none_fails() -> None:
    def simulated(limit: int | None) -> Array:
        short = 10  # samples, so that there are several windows
        slow = Slow(JOINT, THETA, U, SAMPLING_TIME, rest, max_failed_windows=limit, first_window=short)
        return integrate(slow, np.zeros(JOINT.nx), never)

    rest = np.zeros((JOINT.nx, N + 1))
    with pytest.raises(NumericsError, match="too slowly"):
        simulated(0)
    assert np.array_equal(simulated(1), simulated(None))


def test_the_fallback_integrates_as_few_samples_as_there_are_in_the_smallest_window() -> None:
    asked: list[tuple[int, int]] = []

    class Broken(Problem):
        """No step of samples 100 to 107 is finite."""

        def linearise(self, first: int, last: int, x: Array):  # type: ignore[no-untyped-def]
            steps = Problem.linearise(self, first, last, x)
            steps.c[:, (np.arange(first, last) >= 100) & (np.arange(first, last) < 108)] = np.nan
            return steps

    def fallback(first: int, stop: int, start: Array) -> Array:
        asked.append((first, stop))
        return np.repeat(start[:, None], stop - first + 1, axis=1)

    integrate(Broken(JOINT, THETA, U, SAMPLING_TIME, np.zeros((JOINT.nx, N + 1))), np.zeros(JOINT.nx), fallback)
    assert asked
    assert all(stop - first == MIN_WINDOW for first, stop in asked)
    assert {first for first, _ in asked} <= set(range(92, 108))
