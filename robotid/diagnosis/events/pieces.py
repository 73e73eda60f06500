"""Records simulated in short pieces, each from where the motion was: there an event acts on a motion as measured.

In open loop a push, or friction that jumps, leads the simulation of a whole record far away from the motion that was,
and what its columns say there no longer holds.
"""

from __future__ import annotations

from collections.abc import Sequence

from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, segment_fit
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.estimate.fitted_model import FittedModel, simulate_pieces


def scan_pieces(
    model: FittedModel, refitted: RefittedModel, segments: Sequence[Segment], candidates: Sequence[EffectCandidate]
) -> tuple[Scan, ...]:
    """All columns of all segments, cut into pieces. Arguments and errors as of `simulated_pieces`."""
    return scans(simulated_pieces(model, refitted, segments), refitted.unknowns, candidates)


def simulated_pieces(
    model: FittedModel, refitted: RefittedModel, segments: Sequence[Segment], count: int | None = None
) -> list[SegmentFit]:
    """All segments cut into so many pieces each, absent: as many as events are sought in. model : the diagnosed one;
    refitted : its parameters as they are to be. Raises NumericsError where a piece cannot be simulated."""
    current = refitted.put_into(model)
    pieces = [
        Segment(piece, segment.whitening)
        for segment in segments
        for piece in segment.record.divided(count or EVENTS.pieces)
    ]
    trajectories = simulate_pieces(current, [piece.record for piece in pieces])
    return [segment_fit(piece, t, model.output) for piece, t in zip(pieces, trajectories, strict=True)]
