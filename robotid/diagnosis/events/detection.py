"""The largest event of all records: found, judged, and placed in time."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.events.bins import BinnedRecord, Known, binned, even_edges, known_columns, steps_of
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.events.shapes import FRICTION, TORQUE, Shape, best_shapes, significance, strength
from robotid.diagnosis.events.torque_errors import TorqueErrors
from robotid.diagnosis.events.wander import beside_wander
from robotid.diagnosis.results import Event
from robotid.diagnosis.scoring.scan import Scan
from robotid.model.array import Array
from robotid.signals.record import Record

SHAPES = 3  # that may begin in a bin: a bump, a gradual one, a step
KINDS = 8  # of a record, each at any time: bumps of five octaves of lengths, gradual ones, steps of torque, of friction


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


@dataclass(frozen=True, slots=True, eq=False)
class PlacedEvents:
    """The largest events of all records as finely as these show them, beside the fitted parameters only.

    plain : what the fit has shaped; even : borders of equal bins of every record; events : the best of each kind in
    each record.
    """

    plain: Known
    even: dict[str, Array]
    events: tuple[_Placed, ...]

    @property
    def energy(self) -> float:
        """The most that one of them explains, in variances of the noise."""
        return max((one.energy for one in self.events), default=0.0)

    @property
    def share(self) -> float:
        """The same, of all that is beyond the noise on all records."""
        return self.energy / max(self.plain.misfit, 1.0)


def placed_events(scans: Sequence[Scan]) -> PlacedEvents:
    """The largest events of all records. scans : segments with the columns of the fitted parameters; others do not
    count."""
    names = list(dict.fromkeys(one.segment.record.name for one in scans))
    even, plain = (
        {name: even_edges(scans, name) for name in names},
        known_columns(scans, steps_of(scans), catalogue=False),
    )
    coarse = [_Placed(seen, shape) for seen in binned(plain, even) for shape in best_shapes(seen)]
    fine = (_finely(plain, one, even[one.seen.record]) for one in _best_of_each(hopeful(coarse)))
    return PlacedEvents(plain, even, tuple(fine))


def find_event(
    scans: Sequence[Scan], level: float, placed: PlacedEvents | None = None, *, doubtful: bool = False
) -> FoundEvent | None:
    """The event that explains most of the residual of all records, of those that all effects of the catalogue together
    do not explain as well.

    scans : segments with the columns of all candidates. level : of significance, over all events of all records;
    placed : the events of these segments, where they are placed already. doubtful : where none is certain, the one that
    explains most of all. None where there is none.
    """
    placed = placed_events(scans) if placed is None else placed
    beside, even = known_columns(scans, placed.plain.steps, catalogue=True), placed.even
    records = [one.segment.record for one in scans]
    errors = {name: TorqueErrors.of([one for one in records if one.name == name]) for name in even}
    against = _Against(beside, binned(beside, even), errors, level)
    found = [_judged(one, placed.plain, against) for one in placed.events]
    found = [one for one in found if not is_late_torque(one.event, records)]
    certain = [one for one in found if one.event.p_value < level]
    return max(certain or (found if doubtful else []), key=lambda one: one.energy, default=None)


def tries_among(records: Collection[str]) -> int:
    """Of how many events the largest one of so many records, by name, is the largest."""
    return SHAPES * EVENTS.bins * len(records)


def is_late_torque(event: Event, records: Sequence[Record]) -> bool:
    """Whether a bump is no more than a change of the recorded torque would be that acted a sampling interval earlier or
    later: when a torque changes between two samples, no record tells.

    records : or their pieces.
    """
    if event.kind != "bump":
        return False
    pieces = [one for one in records if one.name == event.record]
    t, torque = np.concatenate([one.t for one in pieces]), np.concatenate([one.tau_m for one in pieces])
    h = pieces[0].sampling_time
    near = torque[(t > event.start - 2 * h) & (t < event.end + h)]
    largest = float(np.abs(np.diff(near)).max()) if len(near) > 1 else 0.0
    mean = event.torque / 2 if event.gradual else event.torque
    return abs(mean) * (event.end - event.start) <= largest * h


def energy_of(event: Event, scans: Sequence[Scan]) -> float:
    """What an event explains of the residual of all records, in variances of the noise. scans : as of `placed_events`,
    which may be cut elsewhere."""
    even, column = even_edges(scans, event.record), FRICTION if event.friction else TORQUE
    shape, ends = Shape(event.kind, column, 0, 0, event.gradual), np.clip([event.start, event.end], even[0], even[-1])
    known = known_columns(scans, steps_of(scans), catalogue=False)
    return _placed_between(ends, shape, known, event.record, even).energy


def hopeful(placed: Sequence[_Placed]) -> list[_Placed]:
    """Those that come near the largest."""
    largest = max((one.energy for one in placed), default=0.0)
    return [one for one in placed if one.energy > EVENTS.hopeful_share * largest]


def _best_of_each(placed: Sequence[_Placed]) -> list[_Placed]:
    """The best event of every kind in each record."""
    found: dict[tuple[str, str, int, bool], _Placed] = {}
    for one in sorted(placed, key=lambda one: -one.energy):
        found.setdefault((one.seen.record, one.shape.kind, one.shape.column, one.shape.gradual), one)
    return list(found.values())


def _finely(plain: Known, one: _Placed, even: Array) -> _Placed:
    """An event with its begin and end as finely as the record shows them, over bins that are equal elsewhere. even :
    borders of equal bins of its record."""
    if one.shape.kind != "drift":
        for _ in range(2):
            one = _finer(plain, one)
    ends = one.seen.edges[[one.shape.first, one.shape.last]]
    return _placed_between(ends, one.shape, plain, one.seen.record, even)


def _placed_between(ends: Array, shape: Shape, known: Known, record: str, even: Array) -> _Placed:
    """A shape from its begin to its end (2,) [s] over bins that are equal elsewhere. even : borders of equal bins of
    its record."""
    edges = np.unique(np.concatenate([even, _within(ends, gradual=shape.gradual)]))
    first, last = np.searchsorted(edges, ends).tolist()
    (seen,) = binned(known, {record: edges})
    return _Placed(seen, replace(shape, first=first, last=last))


@dataclass(frozen=True, slots=True, eq=False)
class _Against:
    """What events are judged against. beside : all effects of the catalogue; records : all in equal bins beside these;
    errors : of the torque of each, by name; level : of significance, for less of which no wander is drawn."""

    beside: Known
    records: Sequence[BinnedRecord]
    errors: Mapping[str, TorqueErrors]
    level: float


def _judged(one: _Placed, plain: Known, against: _Against) -> FoundEvent:
    """An event with its size beside the fitted parameters, and its significance beside all effects of the catalogue."""
    seen, shape, name = one.seen, one.shape, one.seen.record
    (left,) = binned(against.beside, {name: seen.edges})
    others = [other for other in against.records if other.record != name]
    p, usual = significance(left, shape, tries_among(against.errors), others, against.errors)
    if p < against.level and shape.kind != "drift":  # which is a wander: it is compared with waves that a wander makes
        p = max(p, beside_wander(left, shape, KINDS * len(against.errors)))
    found, ends = strength(seen, shape), seen.edges[[shape.first, shape.last]]
    event = Event(
        record=name,
        kind=shape.kind,
        friction=shape.column == FRICTION,
        start=float(ends[0]),
        end=float(ends[1]),
        torque=found.amplitude,
        std=found.std * float(np.sqrt(usual)),
        p_value=p if is_its_own(strength(left, shape).energy, found.energy) else 1.0,
        gradual=shape.gradual,
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
    within = _within(old[[shape.first, shape.last]], gradual=shape.gradual)
    edges = np.unique(np.concatenate([old[:1], starts, within, ends, old[-1:]]))
    (finer,) = binned(plain, {coarse.seen.record: edges})
    tried = (
        _Placed(finer, replace(shape, first=int(first), last=int(last)))
        for first in np.searchsorted(edges, starts)
        for last in np.searchsorted(edges, ends)
        if 0 < first < last
    )
    return max(tried, key=lambda one: one.energy)


def _within(ends: Array, *, gradual: bool) -> Array:
    """Borders that bins need within an event: its begin and end (2,), and where it is gradual its course."""
    return np.linspace(ends[0], ends[1], (EVENTS.fine_bins if gradual else 1) + 1)


def _cut(edges: Array, k: int) -> Array:
    """Borders of finer bins from the edge before edge k to the one after it [s]."""
    low, high = edges[max(k - 1, 0)], edges[min(k + 1, len(edges) - 1)]
    return np.linspace(low, high, EVENTS.fine_bins + 1)
