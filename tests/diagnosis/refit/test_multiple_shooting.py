"""A fit by way of short pieces finds what a fit of whole records slips past."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.small_bench import begun, records

from robotid.diagnosis.refit import multiple_shooting
from robotid.diagnosis.refit.multiple_shooting import refit_from_pieces
from robotid.diagnosis.refit.refit import RefitOptions, refit
from robotid.diagnosis.refit.refitted_model import extended
from robotid.signals.record import SHORTEST_PIECE


def test_strong_cogging_is_found_where_a_fit_of_whole_records_slips_into_another_valley() -> None:
    truth = {"motor.cogging.A": 0.15, "motor.cogging.B": -0.075, "motor.cogging.n": 12.0}
    state = begun(records(truth))
    data, first = state.data, state.model
    structure, start = extended(first, "motor.cogging", truth | {"motor.cogging.A": 0.135, "motor.cogging.n": 12.005})
    structure = replace(structure, recorded_angle=False)
    astray = refit(structure, [start], data, first.trajectories)
    # What a start must leave of whole records is no measure of what it leaves of pieces, each from a first guess.
    found = refit_from_pieces(structure, [start], data, RefitOptions(start_below=1e-3 * first.energy))
    assert found.energy < 0.1 * astray.energy
    assert found.validation_energy < 0.2 * astray.validation_energy
    assert found.parameters["motor.cogging.n"] == pytest.approx(truth["motor.cogging.n"], abs=0.005)
    followed = refit(replace(structure, recorded_angle=True), [start], data, first.trajectories)
    assert followed.energy < 1.01 * found.energy
    assert followed.validation_energy < 0.05 * found.validation_energy


def test_pieces_of_a_short_record_are_as_long_as_pieces_must_be() -> None:
    segment = begun(records({})).data.fitted[0]
    brief = replace(segment, record=segment.record.piece(0, 3 * SHORTEST_PIECE))
    assert [len(piece.record) for piece in multiple_shooting._cut([brief])] == [SHORTEST_PIECE] * 3


def test_what_is_in_short_pieces_already_is_not_cut_further() -> None:
    segment = begun(records({})).data.fitted[0]
    pieces = [replace(segment, record=piece) for piece in segment.record.divided(8)]
    assert [one.record.begin for one in multiple_shooting._cut(pieces)] == [one.record.begin for one in pieces]
    halves = [replace(segment, record=piece) for piece in segment.record.divided(2)]
    assert len(multiple_shooting._cut(halves)) == 8
    apart = [pieces[0], pieces[2]]
    assert len(multiple_shooting._cut(apart)) == 16
