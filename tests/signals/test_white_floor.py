"""The noise of a sensor taken out of a signal without shifting it."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.array import Array
from robotid.signals.white_floor import WithoutFloor

N, STD = 4000, 0.2


def motion() -> Array:
    t = np.arange(N) / 1000.0
    return np.asarray(3.0 * np.sin(2 * np.pi * 2.3 * t + 0.4) + np.sign(np.sin(2 * np.pi * 0.8 * t)))


def noise() -> Array:
    return STD * np.random.default_rng(4).standard_normal(N)


def test_most_of_the_noise_is_taken_out_and_the_signal_stays() -> None:
    quiet = WithoutFloor.of(motion() + noise(), STD**2)
    assert np.std(quiet(noise())) < 0.35 * STD
    assert np.std(quiet(motion()) - motion()) < 0.05 * np.std(motion())


def test_nothing_is_shifted_in_time() -> None:
    quiet = WithoutFloor.of(motion() + noise(), STD**2)
    inside = slice(N // 20, -N // 20)
    change, slope = (quiet(motion()) - motion())[inside], np.gradient(motion())[inside]
    assert abs(slope @ change) < 0.01 * (slope @ slope)


@pytest.mark.parametrize("known", [0.0, 0.4 * STD**2])
def test_a_floor_that_no_noise_explains_is_the_signals_own(known: float) -> None:
    random = motion() + noise()
    assert WithoutFloor.of(random, known)(random) == pytest.approx(random, abs=1e-12)


def test_a_short_signal_passes() -> None:
    short = noise()[:50]
    assert WithoutFloor.of(short, STD**2)(short) == pytest.approx(short, abs=1e-12)
