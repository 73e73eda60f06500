"""Records simulated in short pieces, each from where the motion was: there an event acts on a motion as measured.

In open loop a push, or friction that jumps, leads the simulation of a whole record far away from the motion that was,
and what its columns say there no longer holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, segment_fit
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.estimate.fitted_model import FittedModel, simulate_record


def scan_pieces(
    model: FittedModel, refitted: RefittedModel, segments: Sequence[Segment], candidates: Sequence[EffectCandidate]
) -> tuple[Scan, ...]:
    """All columns of all segments, cut into pieces. model : the diagnosed one; refitted : its parameters as they are to
    be. Raises NumericsError where a piece cannot be simulated."""
    current = replace(model, joint=refitted.joint, parameters=refitted.parameters, first_states={})
    pieces = [piece for segment in segments for piece in _pieces(current, segment)]
    return scans(pieces, refitted.unknowns, candidates)


def _pieces(model: FittedModel, segment: Segment) -> Iterator[SegmentFit]:
    run = simulate_record(model, segment.record, segment.record.duration / EVENTS.pieces)
    for piece, trajectory in zip(run.pieces, run.trajectories, strict=True):
        yield segment_fit(Segment(piece, segment.whitening), trajectory, model.output)
