"""Long records are linearised block by block and their covariances gathered span by span; nothing else changes."""

from __future__ import annotations

import weakref
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.estimate import grey_box, least_squares, residual, spans, uncertainty
from robotid.estimate.residual import Evaluation, OutputError
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate


def problem(samples: int = 9_000, *, derived: bool = False) -> OutputError:
    """The paper's joint on a record of two sine waves, noise on torque and speed. derived : the speed comes from the
    angle."""
    t, rng = np.arange(samples) * SAMPLING_TIME, np.random.default_rng(5)
    u = 3.0 * np.sin(2 * np.pi * 0.9 * t) + 2.0 * np.sin(2 * np.pi * 7 * t + 1.0)
    joint = assemble(STRUCTURE)
    parameters = joint.parameters().with_values(TRUTH)
    plain = Record.from_arrays(u, 0 * u, SAMPLING_TIME, speed=0 * u)
    motion = simulate(joint, parameters.values, plain, np.zeros(joint.nx))
    noisy = u + 0.01 * rng.standard_normal(samples), motion.dphi_m + 0.02 * rng.standard_normal(samples)
    record = Record.from_arrays(noisy[0], motion.phi_m, SAMPLING_TIME, speed=None if derived else noisy[1])
    return OutputError(joint, parameters, (record,), "speed", np.ones(1))


@pytest.mark.parametrize("derived", [False, True])
def test_a_long_record_is_linearised_block_by_block(derived: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    one = problem(derived=derived)
    at = one.evaluate(one.start())
    whole = least_squares.linearise(one, at)
    derivatives = one.jacobian(at, 0).values
    monkeypatch.setattr(residual, "MAX_PREDICTION", 0)
    blocks = least_squares.linearise(one, at)
    assert blocks.states == (None,)
    np.testing.assert_allclose(blocks.factor.T @ blocks.factor, whole.factor.T @ whole.factor, rtol=1e-9)
    np.testing.assert_allclose(blocks.gradient, whole.gradient, rtol=1e-9)
    scale = np.abs(derivatives).max(axis=1, keepdims=True)
    np.testing.assert_allclose(one.jacobian(at, 0).values / scale, derivatives / scale, atol=1e-9)
    assert max(part.shape[1] for _, part in one.derivative_blocks(at, 0)) < len(one.records[0])


def test_of_all_evaluations_only_the_latest_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    one, made, alive = problem(), list[weakref.ref[Array]](), list[int]()
    evaluate = OutputError.evaluate

    def noted(*arguments: Any, **options: Any) -> Evaluation:
        found = evaluate(*arguments, **options)
        made.append(weakref.ref(found.residuals[0]))
        return found

    monkeypatch.setattr(OutputError, "evaluate", noted)
    start = one.start() * np.where(np.arange(len(one.start())) < len(one.columns), 1.3, 1.0)
    least_squares.solve(one, start, log=lambda _: alive.append(sum(ref() is not None for ref in made)))
    assert len(alive) > 2
    assert set(alive) == {1}


@pytest.mark.parametrize("wave", [0.0, 0.05])  # [rad/s] of an error that no noise explains
def test_covariances_are_gathered_span_by_span(wave: float, monkeypatch: pytest.MonkeyPatch) -> None:
    one = problem(40_000)
    record = one.records[0]
    shaken = replace(record, dphi_m=record.dphi_m + wave * np.sin(2 * np.pi * 40.0 * record.t))
    one = replace(one, records=(shaken,))
    solution = least_squares.solve(one, one.start(), least_squares.SolveOptions(max_iterations=0))
    sigma = grey_box.noise_levels(one, solution)
    whole = uncertainty.covariances(one, solution, sigma)
    monkeypatch.setattr(spans, "MAX_SAMPLES", 14_000)
    monkeypatch.setattr(spans, "SAMPLED", 10_000)
    monkeypatch.setattr(spans, "FORGOTTEN", 0.2)
    assert len(spans.Spans.of(one, solution.evaluation, 0).cuts) == 3
    cut = uncertainty.covariances(one, solution, sigma)
    np.testing.assert_allclose(np.diag(cut[0]), np.diag(whole[0]), rtol=1e-6)
    np.testing.assert_allclose(np.sqrt(np.diag(cut[1])), np.sqrt(np.diag(whole[1])), rtol=0.25)


def test_a_joint_that_does_not_forget_stays_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    one = problem()
    monkeypatch.setattr(spans, "MAX_SAMPLES", 1_000)
    assert len(spans.Spans.of(one, one.evaluate(one.start()), 0).cuts) == 1
