"""A change of a validation record must explain it, and its fit must rise with it."""

from __future__ import annotations

import numpy as np
from support.plain_models import plain_segment
from support.tuning.search import best_change

from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.search.record_changes import _parts


def test_a_change_with_which_the_fit_falls_is_none() -> None:
    rising, falling = best_change(0.5, gain=0.1), best_change(0.5, gain=-0.3)
    assert rising is not None
    assert falling is None


def test_a_change_is_sought_and_tested_where_it_shows() -> None:
    segment = Segment(plain_segment(1.0).record, UNIT_WHITENING)
    n = len(segment.record)
    residual = np.where(np.arange(n) < n // 2, 1.0, 0.0)  # it rests in the second half
    first, second = _parts(segment, residual)
    assert abs(len(first.record) - n // 4) <= 1
    assert len(first.record) + len(second.record) == n


def test_a_short_piece_is_halved() -> None:
    segment = Segment(plain_segment(1.0).record.piece(0, 12), UNIT_WHITENING)
    first, second = _parts(segment, np.eye(12)[0])
    assert (len(first.record), len(second.record)) == (6, 6)
