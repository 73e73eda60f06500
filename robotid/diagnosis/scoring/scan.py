"""A segment of a record with all columns that may explain its residual."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import SegmentFit, Unknowns
from robotid.diagnosis.scoring.candidate import EffectCandidate, columns_of
from robotid.diagnosis.scoring.columns import columns
from robotid.diagnosis.scoring.settings import SCORING
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.whitening import InnovationsFilter
from robotid.model.array import Array
from robotid.parallel import each
from robotid.signals.white_floor import WithoutFloor

_Shared = tuple[Unknowns, tuple[EffectCandidate, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One segment with all its columns.

    signals (m, n) : derivatives of the output to the first states, to the fitted parameters, to the candidates'
    parameters and to further forces, and last the residual, all in one array, for all go through the same whitening.
    late : the rows of what makes a signal late. The noise of a logged torque drives the simulation, so it is in the
    residual and in those rows, which smooth it and would seem to explain some of it: they are whitened without it.
    """

    segment: SegmentFit
    whitening: InnovationsFilter
    unknowns: Unknowns
    signals: Array
    late: tuple[int, ...] = ()

    @property
    def states(self) -> int:
        """How many columns are of first states."""
        return len(self.unknowns.first_states)

    @property
    def known(self) -> int:
        """How many columns the fit has shaped: of first states and of fitted parameters."""
        return self.states + len(self.unknowns.parameters)

    @property
    def whitened(self) -> Array:
        """All signals through the whitening, (m, n)."""
        if not self.late:
            return self.whitening(self.signals)
        late, signals = list(self.late), self.signals.copy()
        signals[late] = WithoutFloor.of(self.segment.trajectory.u, self.whitening.levels.torque)(signals[late])
        return self.whitening(signals)

    @property
    def bare(self) -> Scan:
        """The segment with what the fit has shaped, and its residual."""
        return replace(self, signals=np.concatenate([self.signals[: self.known], self.signals[-1:]]), late=())

    def with_columns(self, more: Array) -> Scan:
        """The segment with further columns (k, n)."""
        return replace(self, signals=np.concatenate([self.signals[:-1], more, self.signals[-1:]]))

    def with_only(self, at: slice) -> Scan:
        """The segment with what the fit has shaped, the candidates' columns `at`, and its residual."""
        own = self.signals[self.known : -1][at]
        rows = range(self.known, len(self.signals) - 1)[at]
        late = tuple(self.known + k for k, row in enumerate(rows) if row in self.late)
        return replace(self, signals=np.concatenate([self.signals[: self.known], own, self.signals[-1:]]), late=late)

    def whitened_as(self, segment: Segment) -> Scan:
        """The same columns under the noise of another segment."""
        return replace(self, whitening=segment.whitening)

    def with_residual(self, residual: Array) -> Scan:
        """The same columns beside another residual (n,)."""
        return replace(self, signals=np.concatenate([self.signals[:-1], residual[None]]))

    def with_segment(self, segment: SegmentFit) -> Scan:
        """The same columns beside the residual that a similar model leaves, through the whitening of that."""
        return replace(self.with_residual(segment.residual), segment=segment, whitening=segment.whitening)

    def unexplained(self) -> SimulatedSegment:
        """The segment with what is left of its residual when all columns may explain it."""
        known, residual = self.signals[:-1], self.signals[-1]
        length = np.linalg.norm(known, axis=1)
        scaled = known[length > 0] / length[length > 0, None]
        values, vectors = np.linalg.eigh(scaled @ scaled.T)
        kept = values > SCORING.negligible * values[-1]
        basis = vectors[:, kept] / np.sqrt(values[kept])
        left = residual - (basis @ (basis.T @ (scaled @ residual))) @ scaled
        return SimulatedSegment(self.segment.record, self.segment.trajectory, np.asarray(left))


def scan(
    segment: SegmentFit, unknowns: Unknowns, candidates: Sequence[EffectCandidate], forces: Array | None = None
) -> Scan:
    """All columns of one segment. forces : (nv, m, n) further generalised forces."""
    shared = (unknowns, tuple(candidates))
    return _scan(shared, segment, _signals(shared, (segment, forces)))


def scans(
    segments: Sequence[SegmentFit],
    unknowns: Unknowns,
    candidates: Sequence[EffectCandidate],
    forces: Sequence[Array] | None = None,
) -> tuple[Scan, ...]:
    """All columns of every segment. forces : (nv, m, n) each; the rest as of `scan`."""
    each_force: Sequence[Array | None] = [None] * len(segments) if forces is None else forces
    items = list(zip(segments, each_force, strict=False))
    samples = sum(len(one.residual) for one, _ in items) // max(1, len(items))
    shared = (unknowns, tuple(candidates))
    found = each(_signals, shared, items, samples=samples)
    return tuple(_scan(shared, one, signals) for (one, _), signals in zip(items, found, strict=True))


def _signals(shared: _Shared, item: tuple[SegmentFit, Array | None]) -> Array:
    """All columns of a segment, and its residual."""
    unknowns, candidates = shared
    segment, forces = item
    found = columns(segment.trajectory, segment.record, unknowns, candidates, forces)
    signals = [found.first_states, found.parameters, found.candidates, found.forces, segment.residual[None]]
    return np.concatenate(signals)


def _scan(shared: _Shared, segment: SegmentFit, signals: Array) -> Scan:
    """A segment with its signals, and which of them are of what makes a signal late."""
    unknowns, candidates = shared
    first = len(unknowns.first_states) + len(unknowns.parameters)
    pairs = zip(candidates, columns_of(candidates), strict=True)
    late = tuple(first + k for one, at in pairs if one.is_late for k in range(at.start, at.stop))
    return Scan(segment, segment.whitening, unknowns, signals, late)
