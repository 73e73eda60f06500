"""Multiple shooting: a model fitted to short pieces of its records, from where a fit of the whole records starts.

Over a short piece little goes astray, so that a fit finds its way from where a simulation of a whole record, as one of
strong cogging, has slipped into another valley (Bock 1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import QUICK, RefitOptions, refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, Trajectories
from robotid.diagnosis.refit.settings import REFIT
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory


def refit_from_pieces(
    structure: Structure, starts: Sequence[Parameters], data: EvaluationData, options: RefitOptions = QUICK
) -> RefittedModel:
    """The refit by way of short pieces. Raises NumericsError as `refit` does."""
    pieces = replace(data, fitted=_cut(data.fitted), validation=_cut(data.validation))
    short = refit(structure, starts, pieces, options=replace(options, start_below=0.0, reject_above=np.inf))
    near = Trajectories(_joined(short.fitted, data.fitted), _joined(short.validation, data.validation))
    return refit(structure, [short.parameters], data, near, replace(options, start_below=0.0))


def _cut(segments: Sequence[Segment]) -> tuple[Segment, ...]:
    """Short pieces of segments, each with its segment's whitening; segments that are short pieces of a record already
    stay as they are."""
    return tuple(
        replace(segment, record=piece)
        for segment, count in zip(segments, _counts(segments), strict=True)
        for piece in segment.record.divided(count)
    )


def _counts(segments: Sequence[Segment]) -> list[int]:
    """Into how many pieces each segment is cut, so that segments that follow one another are in so many together as one
    alone would be."""
    runs: list[list[Record]] = []
    for record in (segment.record for segment in segments):
        if runs and _follows(record, runs[-1][-1]):
            runs[-1].append(record)
        else:
            runs.append([record])
    return [max(1, round(REFIT.pieces / len(run))) for run in runs for _ in run]


def _follows(record: Record, before: Record) -> bool:
    """Whether a record begins where another one of the same name ends."""
    apart = record.begin - before.begin - before.duration
    return record.name == before.name and abs(apart) < 0.5 * record.sampling_time


def _joined(pieces: Sequence[SegmentFit], segments: Sequence[Segment]) -> tuple[Trajectory, ...]:
    """Trajectories of pieces, as far as they are states, as one a segment."""
    counts = [len(segment.record.divided(count)) for segment, count in zip(segments, _counts(segments), strict=True)]
    edges = np.cumsum([0, *counts]).tolist()
    found = []
    for first, last in pairwise(edges):
        parts = [piece.trajectory for piece in pieces[first:last]]
        found.append(replace(parts[0], x=np.concatenate([t.x for t in parts], axis=1)))
    return tuple(found)
