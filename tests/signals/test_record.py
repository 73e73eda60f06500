"""Records and their pieces."""

from __future__ import annotations

import numpy as np

from robotid.signals.record import Record


def test_without_a_length_the_whole_record_is_one_piece() -> None:
    short = Record("a", "estimate", "both", 0.1, np.zeros(8), np.zeros(8), np.zeros(8), period=0.4)
    (whole,) = short.pieces(None)
    assert len(whole) == 8
    assert whole.period is None
