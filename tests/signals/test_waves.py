import numpy as np
import pytest

from robotid.signals.waves import square, triangle


def test_a_triangle_by_hand() -> None:
    assert triangle(4.0, 8, 10).tolist() == [0, 2, 4, 2, 0, -2, -4, -2, 0, 2]


def test_paper_set_1() -> None:
    """40 rad/s, 5 s, 6.25 s at 2 kHz: 32 rad/s2 all the way, its last sample one before the top."""
    u = triangle(40.0, 10_000, 12_500)
    assert u[[0, 2_500, 5_000, 7_500, 10_000]] == pytest.approx([0, 40, 0, -40, 0], abs=1e-12)
    assert u[-1] == pytest.approx(40 - 32 * 5e-4)
    assert np.abs(np.diff(u)) == pytest.approx(32 * 5e-4)


def test_crest_factor_of_a_triangle_is_root_3() -> None:
    u = triangle(1.0, 40_000, 40_000)
    assert np.abs(u).max() / np.sqrt(np.mean(u**2)) == pytest.approx(np.sqrt(3), rel=1e-6)


def test_a_square_by_hand() -> None:
    assert square(3.0, 4, 7).tolist() == [3, 3, -3, -3, 3, 3, -3]


def test_odd_period_switches_at_the_first_sample_past_the_middle() -> None:
    assert square(1.0, 5, 5).tolist() == [1, 1, 1, -1, -1]


def test_rise_by_hand() -> None:
    """A reversal of 4 samples: from zero, ramps of 1/2 of the amplitude a sample, through zero in the middle."""
    assert square(2.0, 16, 17, rise=4).tolist() == [0, 1, 2, 2, 2, 2, 2, 1, 0, -1, -2, -2, -2, -2, -2, -1, 0]


def test_longest_rise_is_a_triangle() -> None:
    assert square(5.0, 40, 90, rise=20) == pytest.approx(triangle(5.0, 40, 90))


def test_crest_factor_of_a_square_is_one() -> None:
    u = square(8.0, 10_000, 10_000)
    assert np.abs(u).max() / np.sqrt(np.mean(u**2)) == 1.0
