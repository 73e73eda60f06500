"""Samples in blocks."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.array import blocks


@pytest.mark.parametrize("n", [0, 1, 9, 10, 11, 25])
def test_blocks_cover_every_sample_once_and_in_order(n: int) -> None:
    samples = np.arange(n)
    parts = [samples[at] for at in blocks(n, 10)]
    assert np.array_equal(np.concatenate([[], *parts]), samples)
    assert all(0 < len(part) <= 10 for part in parts)
