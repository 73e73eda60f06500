"""Records simulated in short pieces, each from where the motion was: there an event acts on a motion as measured.

In open loop a push, or friction that jumps, leads the simulation of a whole record far away from the motion that was,
and what its columns say there no longer holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, segment_fit
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.estimate.fitted_model import FittedModel, simulate_pieces
from robotid.signals.record import Record


def scan_pieces(
    model: FittedModel, refitted: RefittedModel, segments: Sequence[Segment], candidates: Sequence[EffectCandidate]
) -> tuple[Scan, ...]:
    """All columns of all segments, cut into pieces. Arguments and errors as of `simulated_pieces`."""
    return scans(simulated_pieces(model, refitted, segments), refitted.unknowns, candidates)


def simulated_pieces(
    model: FittedModel, refitted: RefittedModel, segments: Sequence[Segment], further: int = 0
) -> list[SegmentFit]:
    """All segments cut into as many pieces as events are sought in, and so many further ones each; those that are
    pieces of a record in a row already, only as far as they are fewer. model : the diagnosed one; refitted : its
    parameters as they are to be. Raises NumericsError where a piece cannot be simulated."""
    current, lengths = refitted.put_into(model), _in_a_row([segment.record for segment in segments])
    pieces = [
        Segment(piece, segment.whitening)
        for segment, length in zip(segments, lengths, strict=True)
        for piece in segment.record.divided(ceil(EVENTS.pieces / length) + further)
    ]
    trajectories = simulate_pieces(current, [piece.record for piece in pieces])
    return [segment_fit(piece, t, model.output) for piece, t in zip(pieces, trajectories, strict=True)]


def _in_a_row(records: Sequence[Record]) -> list[int]:
    """Of every piece of a record, how many there are in the row of pieces that follow one another to which it belongs;
    one of a record as a whole."""
    rows: list[list[Record]] = []
    for record in records:
        if rows and record.follows(rows[-1][-1]):
            rows[-1].append(record)
        else:
            rows.append([record])
    return [len(row) for row in rows for _ in row]
