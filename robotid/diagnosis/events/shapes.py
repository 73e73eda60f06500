"""Events as sums of bins: where they begin and end, what each explains, and what the rest of the record says of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.stats import f as fisher

from robotid.diagnosis.events.applied import mean_of_gradual
from robotid.diagnosis.events.bins import BinnedRecord
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.events.torque_errors import TorqueErrors, more_by_chance
from robotid.diagnosis.results import EventKind
from robotid.model.array import Array, Index

TORQUE, FRICTION = 0, 1
"""Columns of `BinnedRecord`."""


@dataclass(frozen=True, slots=True)
class Shape:
    """An event over the bins first .. last - 1 of a record. column : TORQUE or FRICTION; gradual : as of an `Event`."""

    kind: EventKind
    column: int
    first: int
    last: int
    gradual: bool = False

    def weights(self, edges: Array) -> Array:
        """Of each of the bins between these edges (B + 1,), (B,)."""
        if self.gradual:
            return mean_of_gradual(edges[:-1], edges[1:], float(edges[self.first]), float(edges[self.last]))
        at = np.arange(len(edges) - 1)
        if self.kind == "drift":
            return np.asarray(((edges[1:] + edges[:-1]) / 2 - edges[0]) / (edges[-1] - edges[0]))
        return np.where((at >= self.first) & (at < self.last), 1.0, 0.0)

    def span(self, edges: Array) -> Array:
        """Begin and end (2,) between these edges [s], of a gradual one where it has half of its height."""
        start, end = edges[self.first], edges[self.last]
        within = (end - start) / 4 if self.gradual else 0.0
        return np.array([start + within, end - within])


@dataclass(frozen=True, slots=True)
class Strength:
    """What an event explains. energy : in variances of the noise; amplitude, std [Nm] : its size, and the standard
    deviation at unit noise."""

    energy: float
    amplitude: float
    std: float


def strength(seen: BinnedRecord, shape: Shape) -> Strength:
    """Of an event, nothing where known columns leave nothing of it."""
    w, k = shape.weights(seen.edges), shape.column
    size, along = float(w @ seen.product[k, :, k] @ w), float(w @ seen.moment[k])
    if size <= EVENTS.least_left * float(w**2 @ seen.whole[k]):
        return Strength(0.0, 0.0, np.inf)
    return Strength(along**2 / size, along / size, size**-0.5)


def best_shapes(seen: BinnedRecord) -> Iterator[Shape]:
    """The bump of torque that explains most of each octave of lengths, a gradual one where it explains more than these,
    the best steps of torque and of friction, and both drifts."""
    count, best = seen.count, 0.0
    energy = window_energies(seen, TORQUE)
    first, last = np.triu_indices(count + 1, 1)
    length = last - first
    longest = max(1, int(EVENTS.longest_bump * count))
    shortest = 1
    while shortest <= longest:
        # A bump ends before the record does.
        chosen = (length >= shortest) & (length < 2 * shortest) & (length <= longest) & (last < count)
        if chosen.any():
            k = int(np.argmax(np.where(chosen & (first > 0), energy[first, last], -1.0)))
            yield Shape("bump", TORQUE, int(first[k]), int(last[k]))
            best = max(best, float(energy[first[k], last[k]]))
        shortest *= 2
    inner = (first > 0) & (last < count) & (length > 1) & (length <= 2 * longest)
    gradual = _gradual_energies(seen, first[inner], last[inner])
    if gradual.max(initial=0.0) > best:
        k = int(np.argmax(gradual))
        yield Shape("bump", TORQUE, int(first[inner][k]), int(last[inner][k]), gradual=True)
    for column in (TORQUE, FRICTION):
        steps = window_energies(seen, column)[2 : count - 1, count]  # else it is the whole record that differs
        yield Shape("step", column, int(np.argmax(steps)) + 2, count)
        yield Shape("drift", column, 0, count)


def window_energies(seen: BinnedRecord, column: int) -> Array:
    """Energy that an event over the bins first .. last - 1 explains, (B + 1, B + 1) by first and last, 0 where it is
    empty or next to nothing of it is left."""
    return _windows(seen, column)[0]


def _windows(seen: BinnedRecord, column: int) -> tuple[Array, Array]:
    """The same energies, and the squared length of the answer to a unit torque over these bins, zero where they are."""
    along = np.concatenate([[0.0], np.cumsum(seen.moment[column])])
    whole = np.concatenate([[0.0], np.cumsum(seen.whole[column])])
    products = np.zeros((seen.count + 1,) * 2)
    products[1:, 1:] = np.cumsum(np.cumsum(seen.product[column, :, column], axis=0), axis=1)
    own = np.diag(products)
    size = own[None, :] + own[:, None] - products - products.T
    numerator = (along[None, :] - along[:, None]) ** 2
    visible = np.triu(size > EVENTS.least_left * (whole[None, :] - whole[:, None]), 1) & (size > 0.0)
    return np.where(visible, numerator / np.where(visible, size, 1.0), 0.0), np.where(visible, size, 0.0)


def _gradual_energies(seen: BinnedRecord, first: Index, last: Index) -> Array:
    """Energy that gradual bumps of torque from edges first to edges last explain, (k,) each."""
    edges = seen.edges
    weights = mean_of_gradual(edges[:-1], edges[1:], edges[first][:, None], edges[last][:, None])
    size = np.einsum("kb,kb->k", weights @ seen.product[TORQUE, :, TORQUE], weights)
    visible = size > EVENTS.least_left * (weights**2 @ seen.whole[TORQUE])
    along = weights @ seen.moment[TORQUE]
    return np.asarray(np.where(visible, along**2 / np.where(visible, size, 1.0), 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class _Alike:
    """Events of the same kind elsewhere in a record. energies (k,) : that they explain; ways : how many of them are
    independent; by_torque (e, k) : of bumps, the energies of errors as large as the recorded torque, of each kind, (0,
    k) where that is not known."""

    energies: Array
    ways: int
    by_torque: Array

    @classmethod
    def of(cls, energies: Array, ways: int) -> _Alike:
        """Of what is not compared with errors of the torque."""
        return cls(energies, ways, np.zeros((0, len(energies))))


def significance(
    seen: BinnedRecord,
    shape: Shape,
    tries: int,
    others: Sequence[BinnedRecord] = (),
    errors: Mapping[str, TorqueErrors] = MappingProxyType({}),
) -> tuple[float, float]:
    """p-value of an event among so many, and the energy by which it was judged: that of the like elsewhere in its
    record, once the event is taken out, and in the other records. It is one where the noise is as it is taken to be.

    What a misfit of another origin leaves is spread over the records, and raises the measure; an event is what stands
    out of it. A measured torque errs in proportion to itself, too: a bump must stand out of as much of that as the like
    elsewhere allow. errors : of the torque of every record, by name; none, and there are no such errors.
    """
    found = strength(seen, shape)
    if found.energy <= 0.0:
        return 1.0, 1.0
    weights, span = shape.weights(seen.edges), shape.span(seen.edges)
    alike = [_like(one.without(seen, shape.column, weights), shape, span, errors) for one in (seen, *others)]
    alike = [one for one in alike if len(one.energies)]
    ways = sum(one.ways for one in alike)
    if ways < 1:
        return 1.0, 1.0
    mean = sum(one.ways * float(np.mean(one.energies)) for one in alike) / ways
    usual = max(1.0, mean)
    if shape.kind == "bump" and errors:
        own = errors[seen.record].mean_squares(*span[:, None])[:, 0] / found.std**2
        energies = np.concatenate([one.energies for one in alike])
        counts = np.concatenate([np.full(len(one.energies), one.ways / len(one.energies)) for one in alike])
        elsewhere = np.concatenate([one.by_torque for one in alike], axis=1)
        usual += more_by_chance(own, elsewhere, energies, counts, usual)
    return float(min(1.0, tries * fisher.sf(found.energy / usual, 1, ways))), usual


def _like(rest: BinnedRecord, shape: Shape, span: Array, errors: Mapping[str, TorqueErrors]) -> _Alike:
    """Events of the same kind elsewhere in a record. span (2,) : begin and end of the event [s]."""
    if shape.kind == "bump":
        return _like_bumps(rest, shape, span, errors.get(rest.record))
    if shape.kind == "step":
        return _Alike.of(_like_steps(rest, shape, span), EVENTS.step_ways)
    return _Alike.of(_like_drifts(rest, shape), EVENTS.drift_ways)


def _like_bumps(rest: BinnedRecord, shape: Shape, span: Array, errors: TorqueErrors | None) -> _Alike:
    """All windows as long as the event that do not touch it; as many as find room side by side are independent."""
    edges, (energies, sizes) = rest.edges, _windows(rest, shape.column)
    start, end, whole = span[0], span[1], edges[-1] - edges[0]
    length = max(end - start, whole / EVENTS.bins)  # a shorter one is compared with the shortest
    first = np.arange(rest.count)
    last = np.searchsorted(edges, edges[:-1] + length - 0.25 * whole / EVENTS.bins)
    apart = (last < rest.count) & ((edges[np.minimum(last, rest.count)] <= start) | (edges[:-1] >= end))
    at, ways = (first[apart], last[apart]), max(0, int((whole - length) / length))
    if errors is None:
        return _Alike.of(energies[at], ways)
    return _Alike(energies[at], ways, errors.mean_squares(*(edges[k] for k in at)) * sizes[at])


def _like_steps(rest: BinnedRecord, shape: Shape, span: Array) -> Array:
    """Energies of steps at all other times but those next to the event's."""
    edges = rest.edges
    apart = np.abs(edges - span[0]) > 1.5 * (edges[-1] - edges[0]) / EVENTS.bins
    at = np.flatnonzero(apart[1:-1]) + 1
    return np.asarray(window_energies(rest, shape.column)[at, rest.count])


def _like_drifts(rest: BinnedRecord, shape: Shape) -> Array:
    """Energies of slow waves, half a period more each, as a torque that wanders at random would have them in a drift:
    its waves are the smaller the shorter they are (Kosambi 1943; Karhunen 1947; Loève 1948)."""
    at = Shape("drift", shape.column, 0, rest.count).weights(rest.edges)
    found = []
    for halves in range(2, EVENTS.drift_ways + 2):
        w, k = np.cos(np.pi * halves * at), shape.column
        size = float(w @ rest.product[k, :, k] @ w)
        if size > EVENTS.least_left * float(w**2 @ rest.whole[k]):
            found.append(halves**2 * float(w @ rest.moment[k]) ** 2 / size)
    return np.array(found)
