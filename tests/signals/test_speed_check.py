"""Whether a speed is the angle's derivative, late, or scaled wrong."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.array import Array
from robotid.signals.differentiate import backward_difference, central_difference
from robotid.signals.speed_check import speed_lag, speed_origin, speed_scale

H = 1e-3
QUANTUM = 2 * np.pi / 65536


def motion(n: int = 6000, quantum: float = QUANTUM) -> tuple[Array, Array]:
    """A multisine's speed, noisy, and the angle as an encoder tells it."""
    rng = np.random.default_rng(2)
    t = np.arange(n) * H
    lines = np.arange(1, 40)
    phase = rng.uniform(0, 2 * np.pi, len(lines))
    omega = 2 * np.pi * lines[:, None]
    speed = np.cos(omega * t + phase[:, None]).sum(axis=0)
    angle = (np.sin(omega * t + phase[:, None]) / omega).sum(axis=0)
    return quantum * np.rint(angle / quantum), speed + 0.05 * rng.normal(size=n)


@pytest.mark.parametrize("lag", [-3, -1, 1, 2, 7])
def test_a_lag_is_found(lag: int) -> None:
    angle, speed = motion()
    a, v = angle[10:-10], speed[10 - lag : len(speed) - 10 - lag]
    assert speed_lag(a, v, H) == pytest.approx(lag, abs=0.1)


def test_half_a_sample_of_a_backward_difference() -> None:
    angle, _ = motion(quantum=1e-9)
    assert speed_lag(angle[1:], np.diff(angle) / H, H) == pytest.approx(0.5, abs=0.1)


def test_no_lag_is_invented() -> None:
    angle, speed = motion()
    assert speed_lag(angle, speed, H) == 0.0
    assert speed_lag(angle, np.gradient(angle, H), H) == 0.0
    assert speed_lag(angle, np.random.default_rng(3).normal(size=len(angle)), H) == 0.0


@pytest.mark.parametrize("scale", [1.0, -1.0, 180 / np.pi, 0.01])
def test_scale(scale: float) -> None:
    angle, speed = motion()
    assert speed_scale(angle, scale * speed, H) == pytest.approx(scale, rel=0.01)


def test_no_scale_where_the_two_do_not_go_together() -> None:
    angle, _ = motion()
    assert speed_scale(angle, np.random.default_rng(3).normal(size=len(angle)), H) is None
    assert speed_scale(angle, np.zeros(len(angle)), H) is None


def test_a_speed_that_was_derived_is_known_by_its_operator() -> None:
    angle, speed = motion()
    assert speed_origin(angle, central_difference(angle, H), H) == "central difference"
    backward = np.concatenate([[0.7], np.diff(angle) / H])  # what was before the first sample is not recorded
    assert speed_origin(angle, backward, H) == "backward difference"
    assert speed_origin(angle, np.round(backward, 4), H) == "sensor"  # other digits than those of the angle
    assert speed_origin(angle, speed, H) == "sensor"
    assert speed_origin(angle[:10], central_difference(angle[:10], H), H) == "sensor"


def test_operators_are_linear_and_of_the_shape_they_are_given() -> None:
    angles = np.stack([motion()[0], np.arange(6000) * H])
    for operator in (central_difference, backward_difference):
        assert operator(angles, H).shape == angles.shape
        assert operator(angles, H)[1] == pytest.approx(np.ones(6000))
        assert operator(angles, H)[0] == pytest.approx(operator(angles[0], H))
