"""Levels of noises whose shapes are known, read off a periodogram that falls steeply."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.diagnosis.noise.spectrum import deviance, likeliest_levels, whittle
from robotid.model.array import Array

LINES = 4000
FREQUENCY = np.arange(1, LINES + 1) / LINES
FALLING = FREQUENCY**-4.0  # as an angle answers a torque, over fourteen orders of magnitude in power
SHAPES = np.stack([np.ones(LINES), FALLING])


def periodogram(output: float, torque: float, redness: float = 0.0, seed: int = 0) -> Array:
    """Each line exponential about a sum of both noises, the torque's redder than white by a power of the frequency."""
    mean = output + torque * FREQUENCY**-redness * FALLING
    return np.asarray(mean * np.random.default_rng(seed).exponential(size=LINES))


@pytest.mark.parametrize(("output", "torque"), [(1.0, 1e-2), (0.3, 1e-1), (1.0, 1e-5)])
def test_levels_are_those_that_made_it(output: float, torque: float) -> None:
    np.testing.assert_allclose(likeliest_levels(periodogram(output, torque), SHAPES), [output, torque], rtol=0.2)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("redness", [0.5, 1.0, 2.0])
def test_no_other_levels_explain_a_periodogram_better(redness: float, seed: int) -> None:
    """Where the errors of the torque are red no levels are true, and steps from a flat spectrum lead to some that leave
    out nearly all of the power."""
    power = periodogram(1e-4, 1e-2, redness, seed)
    levels = likeliest_levels(power, SHAPES)
    least = deviance(power, levels @ SHAPES)
    assert levels[1] > 0.0
    for factors in ((1.02, 1.0), (0.98, 1.0), (1.0, 1.02), (1.0, 0.98), (1.0, 0.0), (0.0, 1.0)):
        assert deviance(power, (levels * factors) @ SHAPES) >= least - 1e-9 * abs(least)


def test_what_is_silent_has_no_noise() -> None:
    """As of a piece so short that the columns of all candidates explain every sample of it."""
    assert not likeliest_levels(np.zeros(LINES), SHAPES).any()
    levels, cost = whittle(np.zeros(LINES), SHAPES)
    assert not levels.any()
    assert cost == 0.0
