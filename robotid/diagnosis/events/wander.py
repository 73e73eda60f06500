"""Whether a torque that wanders slowly by itself, as every recorded torque does, may pass for an event.

The torque of each bin, beyond what is known, is taken for a stationary process with a memory (Ornstein-Uhlenbeck; with
the longest one nearly a random walk) beside noise. What an event gains is the ratio of two likelihoods: that of such a
process beside it, and that of one without, both with the memory and the level that suit them best. A random walk
without its largest trend looks like a process that forgets soon, so that any trend gains something; how much is drawn
from the process without an event (parametric bootstrap; Efron and Tibshirani 1993), of events of the same kind at any
time. A torque that is quiet until it jumps is no such process, however large the level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import gumbel_r

from robotid.diagnosis.events.bins import BinnedRecord
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.events.shapes import TORQUE, Shape
from robotid.model.array import Array

SEED = 1731
TAIL = 2.0
"""Scale of the extremes of what chance gains in minus twice the logarithm of a likelihood, which has a chi-squared
distribution."""


def beside_wander(seen: BinnedRecord, shape: Shape, tries: int) -> float:
    """p-value of a bump or a step being absent, beside a torque that wanders; one where nothing is known.

    seen : its record, the event in it; tries : kinds of events of all records, of which it is the largest.
    """
    count = seen.count
    values, vectors = np.linalg.eigh(seen.product.reshape(2 * count, 2 * count))
    kept = values > EVENTS.dependent * values[-1]
    if int(kept.sum()) < 3:
        return 1.0
    root = np.sqrt(values[kept])
    left = (vectors[:, kept] / root).T @ seen.moment.ravel()  # of unit variance where it is noise
    answers = (vectors[:, kept] * root).reshape(2, count, -1)
    wander = Wander.of(answers[TORQUE], seen.edges)
    at_any_time = np.array([one.weights(seen.edges) @ answers[one.column] for one in _alike(shape, count)])
    found = float(wander.gains(left[None], (shape.weights(seen.edges) @ answers[shape.column])[None])[0, 0])
    by_chance = wander.drawn_gains(left, at_any_time)
    scale = max(TAIL, float(np.std(by_chance)) * np.sqrt(6.0) / np.pi)
    p = gumbel_r.sf(found, float(np.mean(by_chance)) - np.euler_gamma * scale, scale)
    return float(min(1.0, tries * p)) if found > 0.0 else 1.0


def _alike(shape: Shape, count: int) -> list[Shape]:
    """Events of the same kind in so many bins: steps at any time, bumps at any time and as long to within a half."""
    if shape.kind == "step":
        return [Shape("step", shape.column, first, count) for first in range(2, count - 1)]
    length = shape.last - shape.first
    lengths = range(max(1, round(length / 1.5)), round(1.5 * length) + 1)
    return [
        Shape("bump", shape.column, first, first + long, shape.gradual)
        for long in lengths
        for first in range(1, count - long)
    ]


@dataclass(frozen=True, slots=True, eq=False)
class Wander:
    """Processes that a torque may be, by their memories and levels, over what remains of a record (r,).

    directions (m, r, r) : in which a process is independent, variances (m, k, r) : there, noise of one included, at
    every level; known (m, k) : sums of the logarithms of these.
    """

    directions: Array
    variances: Array
    known: Array

    @classmethod
    def of(cls, answers: Array, edges: Array) -> Wander:
        """answers (B, r) : to a torque in each bin between these edges (B + 1,)."""
        middle, whole = (edges[1:] + edges[:-1]) / 2, edges[-1] - edges[0]
        apart = np.abs(middle[:, None] - middle) / whole
        own, directions = np.linalg.eigh(
            np.stack([answers.T @ np.exp(-apart / memory) @ answers for memory in EVENTS.memories])
        )
        shares = np.maximum(own, 0.0) / np.maximum(own[:, -1:], 1e-300)
        variances = 1.0 + tried_levels()[:, None] * shares[:, None]
        return cls(directions, variances, np.log(variances).sum(axis=2))

    def gains(self, left: Array, events: Array) -> Array:
        """What each of the events (e, r) gains in minus twice the logarithm of the likelihood of what is left, of each
        of several such records (d, r), (d, e)."""
        without, beside = np.full(len(left), np.inf), np.full((len(left), len(events)), np.inf)
        for directions, variances, known in zip(self.directions, self.variances, self.known, strict=True):
            drawn, x, weights = left @ directions, events @ directions, 1.0 / variances
            sizes, energy = drawn**2 @ weights.T, np.maximum(weights @ (x**2).T, 1e-300)
            without = np.minimum(without, _unlikelihood(sizes, known, left.shape[1]).min(axis=1))
            for one, y, size in zip(beside, drawn, sizes, strict=True):
                rest = np.maximum(size[:, None] - (weights @ (x * y).T) ** 2 / energy, 0.0)
                np.minimum(one, _unlikelihood(rest, known[:, None], left.shape[1]).min(axis=0), out=one)
        return np.asarray(without[:, None] - beside)

    def drawn_gains(self, left: Array, events: Array) -> Array:
        """The most that any of the events gains in each of many draws of the process that suits best what is left."""
        root = self._likeliest_root(left)
        drawn = np.random.default_rng(SEED).standard_normal((EVENTS.wander_draws, len(left))) @ root.T
        return np.asarray(self.gains(drawn, events).max(axis=1))

    def _likeliest_root(self, left: Array) -> Array:
        """A root (r, r) of the covariance with which what is left is likeliest without an event."""
        best, least = np.eye(len(left)), np.inf
        for directions, variances, known in zip(self.directions, self.variances, self.known, strict=True):
            size = ((left @ directions) ** 2 / variances).sum(axis=1)
            cost = _unlikelihood(size, known, len(left))
            k = int(np.argmin(cost))
            if cost[k] < least:
                factor = max(1.0, float(size[k]) / len(left))
                best, least = directions * np.sqrt(factor * variances[k]), float(cost[k])
        return best


def tried_levels() -> Array:
    """Variances of the wander's largest wave that are tried, over that of the noise."""
    return np.concatenate([[0.0], np.geomspace(EVENTS.least_wander, EVENTS.most_wander, EVENTS.levels)])


def _unlikelihood(size: Array, known: Array, count: int) -> Array:
    """Minus twice the logarithm of the likelihood of so many numbers whose variances are known but for a factor, which
    is one at least. size : sum of their squares over these; known : sum of the logarithms of these."""
    factor = np.maximum(1.0, size / count)
    return np.asarray(count * np.log(factor) + known + size / factor)
