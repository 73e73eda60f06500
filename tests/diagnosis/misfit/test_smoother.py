"""The banded smoother against the same problem in dense matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.diagnosis.misfit import smoother
from robotid.diagnosis.misfit.settings import MISFIT
from robotid.diagnosis.misfit.smoother import Chain
from robotid.model.array import Array

N = 40


def chain(n: int = N) -> Chain:
    """A system of two states that drifts and turns slowly, another at every sample."""
    rng = np.random.default_rng(5)
    turn = 0.1 + 0.05 * np.sin(np.arange(n - 1) / 5)
    G = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    b = np.stack([0.1 + 0.0 * turn, 0.3 + 0.1 * np.cos(np.arange(n - 1))])
    g, y = 0.1 * rng.standard_normal((2, n - 1)), rng.standard_normal(n)
    return Chain(G, g, b, y, 0, 0.3, 0.2, np.array([0.5, -0.5]), np.array([2.0, 3.0]), 1.5)


def prior(c: Chain, step: float) -> tuple[Array, Array, Array]:
    """Mean (n,) and covariance (n, n) of y, and covariance of w with y (n, n)."""
    n = len(c.y)
    walk = np.tril(np.ones((n, n))) * np.append(c.size, np.full(n - 1, step))
    mean, x = np.zeros(n), c.first
    to_y = np.zeros((n, 2 + n - 1))  # of first state and total inputs
    spread = np.concatenate([np.eye(2), np.zeros((2, n - 1))], axis=1)
    for k in range(n):
        mean[k], to_y[k] = x[c.row], spread[c.row]
        if k < n - 1:
            x = c.G[:, :, k] @ x + c.g[:, k]
            spread = c.G[:, :, k] @ spread
            spread[:, 2 + k] += c.b[:, k]
    inputs = walk @ walk.T
    every = np.zeros((n + 1, n + 1))
    every[:2, :2] = np.diag(c.spread**2)
    every[2:, 2:] = inputs[:-1, :-1] + c.torque**2 * np.eye(n - 1)
    return mean, to_y @ every @ to_y.T + c.output**2 * np.eye(n), inputs[:, :-1] @ to_y[:, 2:].T


def evidence(c: Chain, step: float) -> float:
    mean, covariance, _ = prior(c, step)
    e = c.y - mean
    return -0.5 * float(np.linalg.slogdet(covariance)[1] + e @ np.linalg.solve(covariance, e))


def test_the_input_is_its_conditional_mean() -> None:
    c = chain()
    mean, covariance, across = prior(c, 0.2)
    assert c.smooth(0.2).w == pytest.approx(across @ np.linalg.solve(covariance, c.y - mean), abs=1e-9)


def test_the_states_obey_the_system_but_for_the_torque_noise() -> None:
    c = replace(chain(), torque=0.0)
    found = c.smooth(0.2)
    follows = np.einsum("ijn,jn->in", c.G, found.x[:, :-1]) + c.g + c.b * found.w[:-1]
    assert found.x[:, 1:] == pytest.approx(follows, abs=1e-10)


def test_evidence_is_the_likelihood_but_for_a_constant() -> None:
    c, steps = chain(), (0.01, 0.1, 1.0)
    offsets = [c.smooth(step).evidence - evidence(c, step) for step in steps]
    assert np.ptp(offsets) < 1e-6


def test_windows_join_without_a_seam(monkeypatch: pytest.MonkeyPatch) -> None:
    c = chain(600)
    whole = c.smooth(0.05).w
    monkeypatch.setattr(smoother, "WINDOW", 200)
    monkeypatch.setattr(smoother, "OVERLAP", 100)
    monkeypatch.setattr(smoother, "MISFIT", replace(MISFIT, excerpt=150))
    assert c.smooth(0.05).w == pytest.approx(whole, abs=1e-3 * float(np.std(whole)))
    assert len(c.excerpt().y) == 150


def test_where_no_input_moves_the_system_a_step_that_is_lost_in_rounding_is_no_evidence() -> None:
    n, still = 31, np.zeros((1, 30))
    resting = Chain(still[None], still, still, 0.01 * np.sin(np.arange(n)), 0, 0.01, 0.01, np.zeros(1), np.ones(1), 1.0)
    assert np.isfinite(resting.smooth(1e-2).evidence)
    assert resting.smooth(1e-8).evidence == -np.inf
