import numpy as np
import pytest

from robotid.signals.square import square
from robotid.signals.triangle import triangle


def test_samples_by_hand() -> None:
    assert square(3.0, 4, 7).tolist() == [3, 3, -3, -3, 3, 3, -3]


def test_odd_period_switches_at_the_first_sample_past_the_middle() -> None:
    assert square(1.0, 5, 5).tolist() == [1, 1, 1, -1, -1]


def test_rise_by_hand() -> None:
    """A reversal of 4 samples: from zero, ramps of 1/2 of the amplitude a sample, through zero in the middle."""
    assert square(2.0, 16, 17, rise=4).tolist() == [0, 1, 2, 2, 2, 2, 2, 1, 0, -1, -2, -2, -2, -2, -2, -1, 0]


def test_longest_rise_is_a_triangle() -> None:
    assert square(5.0, 40, 90, rise=20) == pytest.approx(triangle(5.0, 40, 90))


def test_crest_factor_is_one() -> None:
    u = square(8.0, 10_000, 10_000)
    assert np.abs(u).max() / np.sqrt(np.mean(u**2)) == 1.0
