"""The largest event of all records: found, judged, and placed in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.events.bins import BinnedRecord, Known, binned, even_edges, known_columns
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.events.shapes import FRICTION, Shape, best_shapes, significance, strength
from robotid.diagnosis.results import Event
from robotid.diagnosis.scoring.scan import Scan
from robotid.model.array import Array


@dataclass(frozen=True, slots=True)
class FoundEvent:
    """An event, and the energy that it explains beside the fitted parameters, in variances of the noise; share : of
    all that is beyond the noise there, on all records."""

    event: Event
    energy: float
    share: float


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """A shape over the bins of its record."""

    seen: BinnedRecord
    shape: Shape

    @property
    def energy(self) -> float:
        return strength(self.seen, self.shape).energy


def find_event(scans: Sequence[Scan], level: float) -> FoundEvent | None:
    """The event that explains most of the residual of all records, of those that all effects of the catalogue together
    do not explain as well.

    scans : segments with the columns of all candidates. level : of significance, over all events of all records. None
    where there is none.
    """
    names = list(dict.fromkeys(one.segment.record.name for one in scans))
    even = {name: even_edges(scans, name) for name in names}
    plain, beside = (known_columns(scans, catalogue=catalogue) for catalogue in (False, True))
    coarse = [_Placed(seen, shape) for seen in binned(plain, even) for shape in best_shapes(seen)]
    tries, others = 2 * EVENTS.bins * len(names), binned(beside, even)
    found = [
        _judged(placed, plain, beside, even[placed.seen.record], others, tries)
        for placed in _best_of_each(hopeful(coarse))
    ]
    return max((one for one in found if one.event.p_value < level), key=lambda one: one.energy, default=None)


def hopeful(placed: Sequence[_Placed]) -> list[_Placed]:
    """Those that come near the largest."""
    largest = max((one.energy for one in placed), default=0.0)
    return [one for one in placed if one.energy > EVENTS.hopeful_share * largest]


def _best_of_each(placed: Sequence[_Placed]) -> list[_Placed]:
    """The best event of every kind in each record."""
    found: dict[tuple[str, str, int], _Placed] = {}
    for one in sorted(placed, key=lambda one: -one.energy):
        found.setdefault((one.seen.record, one.shape.kind, one.shape.column), one)
    return list(found.values())


def _judged(
    coarse: _Placed, plain: Known, beside: Known, even: Array, others: Sequence[BinnedRecord], tries: int
) -> FoundEvent:
    """An event with its begin and end as finely as the record shows them, its size beside the fitted parameters, and
    its significance beside all effects of the catalogue. even : borders of equal bins of its record; others : all
    records in equal bins beside the catalogue."""
    name, one = coarse.seen.record, coarse
    if one.shape.kind != "drift":
        for _ in range(2):
            one = _finer(plain, one)
    ends = one.seen.edges[[one.shape.first, one.shape.last]]
    edges = np.unique(np.concatenate([even, ends]))
    first, last = np.searchsorted(edges, ends).tolist()
    shape = replace(one.shape, first=first, last=last)
    (seen,), (left,) = binned(plain, {name: edges}), binned(beside, {name: edges})
    p, usual = significance(left, shape, tries, [other for other in others if other.record != name])
    found = strength(seen, shape)
    event = Event(
        record=name,
        kind=shape.kind,
        friction=shape.column == FRICTION,
        start=float(ends[0]),
        end=float(ends[1]),
        torque=found.amplitude,
        std=found.std * float(np.sqrt(usual)),
        p_value=p if is_its_own(strength(left, shape).energy, found.energy) else 1.0,
    )
    return FoundEvent(event, found.energy, found.energy / max(plain.misfit, 1.0))


def is_its_own(left: float, energy: float) -> bool:
    """Whether the effects of the catalogue and changes of the record leave enough of what an event explains."""
    return left > EVENTS.own_share * energy


def _finer(plain: Known, coarse: _Placed) -> _Placed:
    """The bins cut finely about the begin and the end of an event, and the event over them that explains most."""
    old, shape = coarse.seen.edges, coarse.shape
    starts = _cut(old, shape.first)
    ends = _cut(old, shape.last) if shape.kind == "bump" else old[-1:]
    edges = np.unique(np.concatenate([old[:1], starts, ends, old[-1:]]))
    (finer,) = binned(plain, {coarse.seen.record: edges})
    tried = (
        _Placed(finer, replace(shape, first=int(first), last=int(last)))
        for first in np.searchsorted(edges, starts)
        for last in np.searchsorted(edges, ends)
        if 0 < first < last
    )
    return max(tried, key=lambda one: one.energy)


def _cut(edges: Array, k: int) -> Array:
    """Borders of finer bins from the edge before edge k to the one after it [s]."""
    low, high = edges[max(k - 1, 0)], edges[min(k + 1, len(edges) - 1)]
    return np.linspace(low, high, EVENTS.fine_bins + 1)
