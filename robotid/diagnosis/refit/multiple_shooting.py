"""Multiple shooting: a model fitted to short pieces of its records, from where a fit of the whole records starts.

Over a short piece little goes astray, so that a fit finds its way from where a simulation of a whole record, as one of
strong cogging, has slipped into another valley (Bock 1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.diagnosis.noise.whitening import Whitening
from robotid.diagnosis.refit.refitted_model import EvaluationData, Motions, RefittedModel, refit
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory

PIECES = 8  # of each record


def try_from_pieces(
    structure: Structure, starts: Sequence[Parameters], bench: EvaluationData, *, enough: float, below: float = np.inf
) -> RefittedModel:
    """As `try_model`, by way of short pieces. Raises NumericsError as that does."""
    short = refit(structure, starts, _shortened(bench), enough=enough)
    near = Motions(_joined(short.motions.fitted, bench.fitted), _joined(short.motions.held, bench.held))
    return refit(structure, [short.parameters], bench, near, below=below)


def _shortened(bench: EvaluationData) -> EvaluationData:
    fitted, whiten = _cut(bench.fitted, bench.whiten)
    held, whiten_held = _cut(bench.held, bench.whiten_held)
    return replace(bench, fitted=fitted, whiten=whiten, held=held, whiten_held=whiten_held)


def _cut(records: Sequence[Record], whiten: Sequence[Whitening]) -> tuple[tuple[Record, ...], tuple[Whitening, ...]]:
    """Pieces of records, each with its record's whitening."""
    pairs = [(piece, w) for r, w in zip(records, whiten, strict=True) for piece in _pieces(r)]
    return tuple(piece for piece, _ in pairs), tuple(w for _, w in pairs)


def _pieces(record: Record) -> tuple[Record, ...]:
    return record.pieces(record.duration / PIECES)


def _joined(pieces: Sequence[Trajectory], records: Sequence[Record]) -> tuple[Trajectory, ...]:
    """Trajectories of pieces, as far as they are states, as one a record."""
    whole, first = list[Trajectory](), 0
    for record in records:
        last = first + len(_pieces(record))
        whole.append(replace(pieces[first], x=np.concatenate([t.x for t in pieces[first:last]], axis=1)))
        first = last
    return tuple(whole)
