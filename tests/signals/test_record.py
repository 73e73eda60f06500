"""Records and their pieces."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.errors import InputError
from robotid.signals.differentiate import central_difference
from robotid.signals.record import Record, usable_horizon


def test_without_a_length_the_whole_record_is_one_piece() -> None:
    short = Record("a", "estimate", "both", 0.1, np.zeros(8), np.zeros(8), np.zeros(8), period=0.4)
    (whole,) = short.pieces(None)
    assert len(whole) == 8
    assert whole.period is None


def test_the_derived_speed_of_a_piece_is_derived_from_the_piece() -> None:
    angle = np.sin(0.3 * np.arange(100))
    whole = Record.from_arrays(angle, angle, 0.1)
    assert whole.speed_origin == "central difference"
    piece = whole.piece(20, 60)
    np.testing.assert_array_equal(piece.dphi_m, central_difference(angle[20:60], 0.1))
    assert piece.dphi_m[0] != whole.dphi_m[20]
    measured = Record.from_arrays(angle, angle, 0.1, speed=whole.dphi_m)
    assert measured.speed_origin == "sensor"
    np.testing.assert_array_equal(measured.piece(20, 60).dphi_m, whole.dphi_m[20:60])


def test_a_signal_that_no_sensor_shows_is_refused() -> None:
    angle = np.sin(0.3 * np.arange(100))
    wild = np.where(np.arange(100) == 50, -1e200, angle)
    with pytest.raises(InputError, match=r"speed reaches 1e\+200, which no sensor of a machine does; check its unit"):
        Record.from_arrays(angle, angle, 0.1, speed=wild)


def test_pieces_that_were_chosen_on_some_records_can_be_cut_of_others() -> None:
    slow = Record("a", "estimate", "both", 0.1, np.zeros(80), np.zeros(80), np.zeros(80))
    fast = Record("b", "estimate", "both", 0.001, np.zeros(80), np.zeros(80), np.zeros(80))
    assert usable_horizon(None, [slow, fast]) is None
    assert usable_horizon(0.0625, [fast]) == 0.0625
    assert usable_horizon(0.0625, [slow, fast]) == 2.0
    assert len(slow.pieces(usable_horizon(0.0625, [slow, fast]))) == 4


def test_a_record_is_divided_into_no_pieces_that_are_too_short() -> None:
    record = Record("a", "estimate", "both", 0.004, np.zeros(62), np.zeros(62), np.zeros(62))
    assert [len(piece) for piece in record.divided(12)] == [21, 20, 21]
    assert [len(piece) for piece in record.divided(2)] == [31, 31]
    assert [len(piece) for piece in record.piece(0, 10).divided(12)] == [10]
