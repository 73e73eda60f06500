"""Samples in blocks."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.array import Index, blocks, taken


@pytest.mark.parametrize("n", [0, 1, 9, 10, 11, 25])
def test_blocks_cover_every_sample_once_and_in_order(n: int) -> None:
    samples = np.arange(n)
    parts = [samples[at] for at in blocks(n, 10)]
    assert np.array_equal(np.concatenate([[], *parts]), samples)
    assert all(0 < len(part) <= 10 for part in parts)


@pytest.mark.parametrize("at", [np.array([4, 1, 1, 3]), slice(1, 4), np.array([], dtype=int)])
def test_taken_samples_are_those_of_an_index(at: Index | slice) -> None:
    signals = np.arange(15.0).reshape(3, 5)
    np.testing.assert_array_equal(taken(signals, at), signals[:, at])
    np.testing.assert_array_equal(taken(signals > 6.0, at), (signals > 6.0)[:, at])


def test_rows_of_taken_samples_lie_in_one_piece_of_memory() -> None:
    assert taken(np.zeros((3, 50)), np.array([7, 3, 30])).flags.c_contiguous
