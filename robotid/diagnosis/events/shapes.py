"""Events as sums of bins: where they begin and end, what each explains, and what the rest of the record says of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2
from scipy.stats import f as fisher

from robotid.diagnosis.events.applied import mean_of_gradual
from robotid.diagnosis.events.bins import BinnedRecord
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.results import EventKind
from robotid.model.array import Array, Complex, Index

TORQUE, FRICTION = 0, 1
"""Columns of `BinnedRecord`."""
PARTS = 41
"""Of errors in proportion to the torque that are tried, from none to all: enough for any interval."""


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
    along = np.concatenate([[0.0], np.cumsum(seen.moment[column])])
    numerator, size = (along[None, :] - along[:, None]) ** 2, _window_sizes(seen, column)
    return np.asarray(np.where(size > 0.0, numerator / np.where(size > 0.0, size, 1.0), 0.0))


def _window_sizes(seen: BinnedRecord, column: int) -> Array:
    """Squared length of the answer to a unit torque over the bins first .. last - 1, the same way."""
    whole = np.concatenate([[0.0], np.cumsum(seen.whole[column])])
    products = np.zeros((seen.count + 1,) * 2)
    products[1:, 1:] = np.cumsum(np.cumsum(seen.product[column, :, column], axis=0), axis=1)
    own = np.diag(products)
    size = own[None, :] + own[:, None] - products - products.T
    visible = np.triu(size > EVENTS.least_left * (whole[None, :] - whole[:, None]), 1)
    return np.asarray(np.where(visible, np.maximum(size, 0.0), 0.0))


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
    independent; by_torque (e, k) : of bumps, the energies of errors as large as the recorded torque, of each kind."""

    energies: Array
    ways: int
    by_torque: Array | None = None


def significance(
    seen: BinnedRecord, shape: Shape, tries: int, others: Sequence[BinnedRecord] = ()
) -> tuple[float, float]:
    """p-value of an event among so many, and the energy by which it was judged: that of the like elsewhere in its
    record, once the event is taken out, and in the other records. It is one where the noise is as it is taken to be.

    What a misfit of another origin leaves is spread over the records, and raises the measure; an event is what stands
    out of it. A measured torque errs in proportion to itself, too, as gains and ripples do: a bump must stand out of as
    much of that as the like elsewhere allow.
    """
    found = strength(seen, shape)
    if found.energy <= 0.0:
        return 1.0, 1.0
    weights, span = shape.weights(seen.edges), shape.span(seen.edges)
    alike = [_like(one.without(seen, shape.column, weights), shape, span) for one in (seen, *others)]
    alike = [one for one in alike if len(one.energies)]
    ways = sum(one.ways for one in alike)
    if ways < 1:
        return 1.0, 1.0
    mean = sum(one.ways * float(np.mean(one.energies)) for one in alike) / ways
    usual = max(1.0, mean)
    if shape.kind == "bump":
        usual += _more_by_torque(_by_torque(seen, *span[:, None])[:, 0] / found.std**2, alike, usual)
    return float(min(1.0, tries * fisher.sf(found.energy / usual, 1, ways))), usual


def _by_torque(seen: BinnedRecord, begin: Array, end: Array) -> Array:
    """Mean squares of errors as large as the recorded torque between times (k,) [Nm2], (e, k): of ones that are
    independent from sample to sample, and of ones that ripple along the motor's angle, from a gain on."""

    def mean(course: Array | Complex) -> Array:
        return np.asarray((np.interp(end, seen.edges, course) - np.interp(begin, seen.edges, course)) / (end - begin))

    return np.stack([mean(seen.squared), *(np.abs(mean(course)) ** 2 for course in seen.rippled)])


def _more_by_torque(own: Array, alike: Sequence[_Alike], usual: float) -> float:
    """By how much more than `usual`, which the like have in the mean, a bump explains by chance where part of that is
    errors in proportion to the torque, and these are larger there than in the mean: the most within a 95 % interval of
    the likelihood of their kind and part, each energy being that of one normal number.

    own (e,) : energy of an error as large as the recorded torque there, of each kind.
    """
    parts = [(one, one.by_torque) for one in alike if one.by_torque is not None]
    energies = np.concatenate([one.energies for one, _ in parts])
    counts = np.concatenate([np.full(len(one.energies), one.ways / len(one.energies)) for one, _ in parts])
    every = np.concatenate([by_torque for _, by_torque in parts], axis=1)
    mean = np.maximum(every @ counts / counts.sum(), 1e-300)
    tried = np.linspace(0.0, usual - 1.0, PARTS)
    beyond = tried[:, None, None] * (every / mean[:, None] - 1.0)  # part, kind, window
    levels = usual + beyond
    unlikelihood = (np.log(levels) + energies / levels) @ counts
    likely = unlikelihood <= unlikelihood.min() + chi2.isf(0.05, 1)
    return float(max(0.0, np.where(likely, tried[:, None] * (own / mean - 1.0), 0.0).max()))


def _like(rest: BinnedRecord, shape: Shape, span: Array) -> _Alike:
    """Events of the same kind elsewhere in a record. span (2,) : begin and end of the event [s]."""
    if shape.kind == "bump":
        return _like_bumps(rest, shape, span)
    if shape.kind == "step":
        return _Alike(_like_steps(rest, shape, span), EVENTS.step_ways)
    return _Alike(_like_drifts(rest, shape), EVENTS.drift_ways)


def _like_bumps(rest: BinnedRecord, shape: Shape, span: Array) -> _Alike:
    """All windows as long as the event that do not touch it; as many as find room side by side are independent."""
    edges, energies = rest.edges, window_energies(rest, shape.column)
    start, end, whole = span[0], span[1], edges[-1] - edges[0]
    length = max(end - start, whole / EVENTS.bins)  # a shorter one is compared with the shortest
    first = np.arange(rest.count)
    last = np.searchsorted(edges, edges[:-1] + length - 0.25 * whole / EVENTS.bins)
    apart = (last < rest.count) & ((edges[np.minimum(last, rest.count)] <= start) | (edges[:-1] >= end))
    first, last = first[apart], last[apart]
    by_torque = _by_torque(rest, edges[first], edges[last]) * _window_sizes(rest, shape.column)[first, last]
    return _Alike(energies[first, last], max(0, int((whole - length) / length)), by_torque)


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
