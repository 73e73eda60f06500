"""Whether a torque that wanders slowly by itself, as every recorded torque does, may pass for an event.

The torque of each bin, beyond what is known, is taken for a stationary process with a memory (Ornstein-Uhlenbeck; with
the longest one nearly a random walk) beside noise. Memory and level are those that make the record likeliest without an
event, and it is tested beside errors that are so correlated (generalised least squares; Aitken 1936): a jump is not one
of the many small ones of such a process. They are not sought anew beside the event, for a random walk without its trend
looks like a process that forgets soon, and any trend of it like an event.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import f as fisher

from robotid.diagnosis.events.bins import BinnedRecord
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.events.shapes import TORQUE, Shape
from robotid.model.array import Array


def beside_wander(seen: BinnedRecord, shape: Shape, tries: int) -> float:
    """p-value of a bump or a step among so many being absent, beside a torque that wanders; one where nothing is known.

    seen : its record, the event in it.
    """
    count = seen.count
    values, vectors = np.linalg.eigh(seen.product.reshape(2 * count, 2 * count))
    kept = values > EVENTS.dependent * values[-1]
    ways = int(kept.sum()) - 1
    if ways < 1:
        return 1.0
    root = np.sqrt(values[kept])
    left = (vectors[:, kept] / root).T @ seen.moment.ravel()  # of unit variance where it is noise
    answers = (vectors[:, kept] * root).reshape(2, count, ways + 1)
    event = shape.weights(seen.edges) @ answers[shape.column]
    variances, directions = _likeliest(left, answers[TORQUE], seen.edges)
    y, x = (directions.T @ one / np.sqrt(variances) for one in (left, event))
    explained = float(x @ y) ** 2 / max(float(x @ x), 1e-300)
    usual = max(1.0, (float(y @ y) - explained) / ways)
    return float(min(1.0, tries * fisher.sf(explained / usual, 1, ways)))


def _likeliest(left: Array, answers: Array, edges: Array) -> tuple[Array, Array]:
    """Variances (n,), but for a factor, and directions (n, n) of what is left (n,), at the memory and the level of the
    wandering torque with which it is likeliest. answers (B, n) : to a torque in each bin."""
    middle, whole = (edges[1:] + edges[:-1]) / 2, edges[-1] - edges[0]
    apart = np.abs(middle[:, None] - middle) / whole
    best, least, levels = (np.ones(len(left)), np.eye(len(left))), np.inf, tried_levels()
    for memory in EVENTS.memories:
        own, directions = np.linalg.eigh(answers.T @ np.exp(-apart / memory) @ answers)
        own, y = np.maximum(own, 0.0) / max(float(own[-1]), 1e-300), directions.T @ left
        for level in levels:
            variances = 1.0 + level * own
            unlikelihood = _unlikelihood(y, variances)
            if unlikelihood < least:
                best, least = (variances, directions), unlikelihood
    return best


def tried_levels() -> Array:
    """Variances of the wander's largest wave that are tried, over that of the noise."""
    return np.concatenate([[0.0], np.geomspace(EVENTS.least_wander, EVENTS.most_wander, EVENTS.levels)])


def _unlikelihood(left: Array, variances: Array) -> float:
    """Minus twice the logarithm of the likelihood of what is left (n,), whose variances (n,) are known but for a
    factor, which is one at least."""
    factor = max(1.0, float(np.mean(left**2 / variances)))
    return float(np.sum(np.log(factor * variances) + left**2 / (factor * variances)))
