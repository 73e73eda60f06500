"""An interrupt ends a fit soon, wherever it is, and what was reached before is kept where that takes no time."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from robotid import interrupt
from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate import grey_box
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.lifted import engine
from robotid.estimate.result import End, FitResult
from robotid.estimate.scrutiny import FitTask, scrutinised_fit, task
from robotid.interrupt import Interrupted, interruptible
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.progress import Iteration
from robotid.signals.record import Record
from robotid.simulation.newton.problem import Problem
from robotid.simulation.simulate import simulate

JOINT = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
TRUTH = {"motor.inertia.J": 0.01, "motor.viscous.Fv": 0.02, "motor.coulomb.Fc": 0.1}
START = JOINT.parameters().with_values({name: 1.5 * value for name, value in TRUTH.items()})
H = 1e-3
OPTIONS = FitOptions(interruptible=True)


@cache
def record() -> Record:
    t = np.arange(800) * H
    u = 0.5 * np.sin(2 * np.pi * 3 * t) + 0.3 * np.sin(2 * np.pi * 11 * t)
    still = Record("log", "estimate", "both", H, u, 0 * u, 0 * u)
    speed = simulate(JOINT, JOINT.parameters().with_values(TRUTH).values, still, np.zeros(1)).dphi_m
    return replace(still, dphi_m=speed + 0.01 * np.random.default_rng(1).standard_normal(len(t)))


def send_at(number: int) -> Callable[[Iteration], None]:
    def log(one: Iteration) -> None:
        if one.number == number:
            signal.raise_signal(signal.SIGTERM)

    return log


def test_an_iterate_that_cannot_be_simulated_is_not_fitted_from_the_start_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An interrupt in a fit of an unstable axis: the fit went on with whole simulations."""

    def diverges(*_: object) -> None:
        raise NumericsError("the simulation diverges", hint="for a test")

    monkeypatch.setattr(engine, "_simulation", diverges)
    monkeypatch.setattr(engine.least_squares, "solve", lambda *_, **__: pytest.fail("it goes on"))
    with interruptible(), pytest.raises(Interrupted):
        fit_model("m", JOINT, START, [record()], OPTIONS, send_at(2))


def test_an_iterate_that_takes_long_to_simulate_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    works = engine._simulation

    def slow(*arguments: Any) -> Any:
        interrupt.check()
        return works(*arguments)

    monkeypatch.setattr(engine, "_simulation", slow)
    monkeypatch.setattr(interrupt, "WIND_UP", -1.0)
    with interruptible(), pytest.raises(Interrupted):
        fit_model("m", JOINT, START, [record()], OPTIONS, send_at(2))


def test_deviations_that_take_long_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    works = grey_box.covariances

    def slow(*arguments: Any) -> Any:
        interrupt.check()
        return works(*arguments)

    monkeypatch.setattr(grey_box, "covariances", slow)
    monkeypatch.setattr(interrupt, "WIND_UP", -1.0)
    with interruptible(), pytest.raises(Interrupted):
        fit_model("m", JOINT, START, [record()], OPTIONS, send_at(2))


def test_a_signal_is_seen_between_two_newton_iterations(monkeypatch: pytest.MonkeyPatch) -> None:
    works, calls = Problem.linearise, list[int]()

    def linearise(self: Problem, first: int, last: int, x: Array) -> Any:
        calls.append(last - first)
        signal.raise_signal(signal.SIGTERM)
        return works(self, first, last, x)

    monkeypatch.setattr(Problem, "linearise", linearise)
    with interruptible(), pytest.raises(Interrupted):
        simulate(JOINT, START.values, record(), np.zeros(1))
    assert len(calls) == 1


def interrupted_further_fit(monkeypatch: pytest.MonkeyPatch, options: FitOptions) -> FitResult:
    """A poor fit whose second attempt is interrupted."""
    fits = list[FitOptions]()

    def fit(*arguments: Any) -> FitResult:
        fits.append(arguments[4])
        if len(fits) == 2:
            raise KeyboardInterrupt
        return replace(fit_model(*arguments), fit_percent={"log": 10.0})

    monkeypatch.setattr(task, "fit_model", fit)
    found = scrutinised_fit(FitTask("m", JOINT, START, [record()], options)).fit
    assert len(fits) == 2, "nothing is tried after an interrupt"
    return found


def test_the_first_fit_is_kept_where_a_second_one_is_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    found = interrupted_further_fit(monkeypatch, OPTIONS)
    assert found.end is End.INTERRUPTED
    assert found["motor.inertia.J"].value == pytest.approx(TRUTH["motor.inertia.J"], rel=0.01)


def test_python_gets_its_own_interrupt_from_a_second_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(KeyboardInterrupt):
        interrupted_further_fit(monkeypatch, FitOptions())


def test_an_interrupt_while_whole_simulations_follow_a_stalled_fit_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    works = engine.solve

    def stalls(*arguments: Any, **named: Any) -> Any:
        return replace(works(*arguments, **named), end=End.STALLED)

    def interrupted(*_: object, **__: object) -> None:
        raise Interrupted

    monkeypatch.setattr(grey_box.lifted, "solve", stalls)
    monkeypatch.setattr(grey_box, "solve", interrupted)
    assert fit_model("m", JOINT, START, [record()], OPTIONS).end is End.INTERRUPTED
    with pytest.raises(Interrupted):
        fit_model("m", JOINT, START, [record()], FitOptions())


def test_an_interrupt_before_the_first_coarse_step_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise Interrupted

    monkeypatch.setattr(engine, "coarse_factor", lambda _: 2)
    monkeypatch.setattr(engine.Descent, "advance", interrupted)
    found = fit_model("m", JOINT, START, [record()], OPTIONS)
    assert (found.end, found.iterations) == (End.INTERRUPTED, 0)
