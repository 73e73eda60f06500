"""Standard deviations against the scatter of repeated experiments."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from scipy.signal import lfilter
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.estimate.covariance import (
    autoregression,
    coloured_information,
    impulse_response,
    sandwich,
    zero_order_hold_response,
)

N = 2000
T = np.linspace(0, 1, N)
JACOBIAN = np.stack([np.ones(N), T, np.sin(40 * T)])


def scatter(errors: np.ndarray) -> np.ndarray:
    """Covariance of J e over many draws of e, (3, 3). errors (draws, N)."""
    return np.cov(JACOBIAN @ errors.T)


def test_autoregression_finds_a_known_one() -> None:
    e = lfilter([1.0], [1.0, -0.8], np.random.default_rng(0).standard_normal(20_000))
    a, variance = autoregression(e)
    assert a[0] == pytest.approx(0.8, abs=0.02)
    assert variance == pytest.approx(1.0, rel=0.03)


def test_white_residuals_give_the_classical_information() -> None:
    e = np.random.default_rng(1).standard_normal(N)
    assert coloured_information(JACOBIAN, e) == pytest.approx(np.var(e) * JACOBIAN @ JACOBIAN.T, rel=0.05)


def test_a_response_to_an_impulse_is_that_of_the_steps_one_by_one() -> None:
    joint = assemble(STRUCTURE, angle=True)
    theta = joint.parameters().with_values(TRUTH).values
    A, b = zero_order_hold_response(joint, theta, SAMPLING_TIME)
    x = np.zeros(joint.nx)
    expected = np.empty((1000, joint.nx))
    for k in range(len(expected)):
        expected[k] = x
        x = A @ x + (b if k == 0 else 0.0)
    for row in range(joint.nx):
        for n in (1, 2, 999, 1000):
            found = impulse_response(joint, theta, row, SAMPLING_TIME, n)
            np.testing.assert_allclose(found, expected[:n, row], rtol=1e-9, atol=1e-12 * np.abs(expected[:, row]).max())


def test_the_response_is_kept_for_the_parameters_and_the_interval_that_it_was_asked_for() -> None:
    joint = assemble(STRUCTURE)
    theta = joint.parameters().with_values(TRUTH).values
    A, b = zero_order_hold_response(joint, theta, SAMPLING_TIME)
    stiffer = theta.copy()
    stiffer[list(joint.names).index("gear.spring.k1")] *= 2.0
    others = [(joint, stiffer, SAMPLING_TIME), (joint, theta, 2.0 * SAMPLING_TIME)]
    assert not any(np.array_equal(zero_order_hold_response(*one)[0], A) for one in others)
    again, _ = zero_order_hold_response(joint, theta.copy(), SAMPLING_TIME)
    assert np.shares_memory(again, A)
    for kept in (A, b):
        with pytest.raises(ValueError, match="read-only"):
            kept[0] = 0.0


def test_a_response_to_an_impulse_takes_no_more_memory_than_a_few_signals() -> None:
    joint, n = assemble(STRUCTURE, angle=True), 200_000
    theta = joint.parameters().with_values(TRUTH).values
    tracemalloc.start()
    impulse_response(joint, theta, joint.motor_speed, SAMPLING_TIME, n)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 4 * 8 * n


def test_coloured_residuals_give_the_scatter_of_repetitions() -> None:
    rng = np.random.default_rng(2)
    errors = lfilter([1.0], [1.0, -0.9], rng.standard_normal((400, N + 200)), axis=1)[:, 200:]
    expected = np.sqrt(np.diag(scatter(errors)))
    found = np.mean([np.sqrt(np.diag(coloured_information(JACOBIAN, e))) for e in errors[:40]], axis=0)
    assert found == pytest.approx(expected, rel=0.15)


def test_integrated_torque_noise_is_seen_beneath_white_noise() -> None:
    rng = np.random.default_rng(3)
    impulse = np.concatenate([[0.0], 0.02 * 0.999 ** np.arange(N - 1)])
    torque = lfilter(impulse[:N], [1.0], rng.standard_normal((200, N)), axis=1)
    errors = torque + 0.5 * rng.standard_normal((200, N))
    expected = np.sqrt(np.diag(scatter(errors)))
    found = np.median([np.sqrt(np.diag(coloured_information(JACOBIAN, e, impulse))) for e in errors[:60]], axis=0)
    assert found == pytest.approx(expected, rel=0.35)
    blind = np.median([np.sqrt(np.diag(coloured_information(JACOBIAN, e))) for e in errors[:60]], axis=0)
    assert blind[0] < 0.75 * expected[0]


def test_asandwich_stays_a_covariance_where_its_parts_are_of_unlike_size() -> None:
    rng = np.random.default_rng(3)
    half = rng.standard_normal((4, 4))
    outer, middle = np.eye(4) + 0.1 * half, half @ half.T
    assert sandwich(outer, middle) == pytest.approx(outer @ middle @ outer.T)
    along = rng.standard_normal(4)
    outer = 1e8 * (np.eye(4) - np.outer(along, along) / (along @ along))
    middle = np.outer(along, along)
    assert np.diag(outer @ middle @ outer.T).min() < 0.0  # by rounding
    assert np.diag(sandwich(outer, middle)).min() >= 0.0
