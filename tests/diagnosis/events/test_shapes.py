"""What a bump is compared with: the others of its record, and errors in proportion to the recorded torque."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.diagnosis.events.bins import BinnedRecord
from robotid.diagnosis.events.shapes import TORQUE, Shape, significance
from robotid.diagnosis.events.torque_errors import TorqueErrors
from robotid.model.array import Array

BINS, DURATION = 48, 4.8
SEEN = 1e4
"""Energy of an error of 1 Nm in a bin."""
AT = 30
"""The bin in which something may be."""


EDGES = np.linspace(0.0, DURATION, BINS + 1)


def binned(error: Array, rng: np.random.Generator) -> BinnedRecord:
    """A record with errors of the torque (B,) [Nm] in its bins, beside noise of unit variance."""
    product = SEEN * np.eye(2 * BINS).reshape(2, BINS, 2, BINS)
    moment = np.sqrt(SEEN) * rng.standard_normal((2, BINS))
    moment[TORQUE] += SEEN * error
    return BinnedRecord("r", EDGES, product, moment, np.zeros((2, BINS, 0)), np.full((2, BINS), SEEN))


def errors(torque: Array, rippled: float | Array = 0.0) -> dict[str, TorqueErrors]:
    """Those of its torque (B,). rippled : (B,) what remains of it in each bin where it ripples along the angle."""
    squared, ripple = (np.append(0.0, np.cumsum(one * np.ones(BINS))) * DURATION / BINS for one in (torque**2, rippled))
    return {"r": TorqueErrors(EDGES, squared, ripple[None] + 0j)}


def course(at: float) -> Array:
    """A torque of 1 Nm, of another size in one bin, as where a heavy joint is thrown round."""
    return np.where(np.arange(BINS) == AT, at, 1.0)


BUMP = Shape("bump", TORQUE, AT, AT + 1)


def test_errors_in_proportion_to_the_torque_are_no_event_where_it_is_largest() -> None:
    rng, torque, p, blind = np.random.default_rng(0), course(5.0), [], []
    for _ in range(400):
        seen = binned(0.02 * torque * rng.standard_normal(BINS), rng)
        p.append(significance(seen, BUMP, 1, (), errors(torque))[0])
        blind.append(significance(seen, BUMP, 1)[0])
    assert np.mean(np.array(p) < 0.01) <= 0.02
    assert np.mean(np.array(blind) < 0.01) > 0.4


def test_a_ripple_shows_where_the_motor_hardly_turns() -> None:
    """Elsewhere it cancels within the bin, under the same torque."""
    rng, torque = np.random.default_rng(3), course(1.0)
    slow = np.where(np.arange(BINS) % 10 == 0, 1.0, 0.1)
    p = [
        significance(binned(0.05 * slow * rng.standard_normal(BINS), rng), BUMP, BINS, (), errors(torque, slow))[0]
        for _ in range(400)
    ]
    assert np.mean(np.array(p) < 1e-3) <= 0.01


@pytest.mark.parametrize(("torque", "push"), [(1.0, 0.1), (0.1, 0.1), (5.0, 0.5)], ids=["usual", "little", "most"])
def test_a_push_stands_out_of_them(torque: float, push: float) -> None:
    rng, drawn = np.random.default_rng(1), course(torque)
    pushed = push * (np.arange(BINS) == AT)
    found = [
        significance(binned(0.01 * drawn * rng.standard_normal(BINS) + pushed, rng), BUMP, BINS, (), errors(drawn))[0]
        for _ in range(40)
    ]
    assert np.median(found) < 1e-3


def test_beside_the_noise_alone_hardly_more_is_asked_of_a_push_under_an_ordinary_torque() -> None:
    rng, torque = np.random.default_rng(2), course(1.0)
    pushed = 0.1 * (np.arange(BINS) == AT)
    seen = [binned(pushed, rng) for _ in range(100)]
    usual = [significance(one, BUMP, 1, (), errors(torque))[1] for one in seen]
    plain = [significance(one, BUMP, 1)[1] for one in seen]
    assert np.mean(usual) < np.mean(plain) + 1.0
