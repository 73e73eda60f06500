import numpy as np
import pytest

from robotid.signals.triangle import triangle


def test_samples_by_hand() -> None:
    assert triangle(4.0, 8, 10).tolist() == [0, 2, 4, 2, 0, -2, -4, -2, 0, 2]


def test_paper_set_1() -> None:
    """40 rad/s, 5 s, 6.25 s at 2 kHz: 32 rad/s2 all the way, its last sample one before the top."""
    u = triangle(40.0, 10_000, 12_500)
    assert u[[0, 2_500, 5_000, 7_500, 10_000]] == pytest.approx([0, 40, 0, -40, 0], abs=1e-12)
    assert u[-1] == pytest.approx(40 - 32 * 5e-4)
    assert np.abs(np.diff(u)) == pytest.approx(32 * 5e-4)


def test_crest_factor_is_root_3() -> None:
    u = triangle(1.0, 40_000, 40_000)
    assert np.abs(u).max() / np.sqrt(np.mean(u**2)) == pytest.approx(np.sqrt(3), rel=1e-6)
