"""What effects of a size would add to the residuals of a model that is fitted without them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.diagnosis.scoring.projection import Projected
from robotid.diagnosis.scoring.scan import Scan
from robotid.model.array import Array


def in_any_proportion(at: slice, size: float = 1.0) -> Array:
    """The amplitudes of the columns `at` with which an effect has a size, whatever their proportion, (k,)."""
    count = at.stop - at.start
    return np.full(count, size / np.sqrt(count))


def added_signals(scans: Sequence[Scan], projected: Projected, effects: Sequence[tuple[slice, Array]]) -> list[Array]:
    """What each effect adds to the residual of every segment, less what the fit and the first states would take of it,
    (effects, n) each, in the unit of the output.

    scans : every segment with all columns; projected : these; effects : where the columns of each are, and its
    amplitudes (k,).
    """
    ways = np.zeros((len(effects), len(projected.fitted) + projected.missing.shape[1]))
    nothing, fitted = projected.moved(np.zeros(0), slice(0, 0)), len(projected.fitted)
    for way, (at, amplitude) in zip(ways, effects, strict=True):
        way[fitted:][at] = amplitude
        way[:fitted] = nothing - projected.moved(-amplitude, at)
    return [_beyond_states(one, ways @ one.signals[one.states : -1]) for one in scans]


def _beyond_states(one: Scan, added: Array) -> Array:
    """Signals (k, n) less what the first states of a segment would take of them."""
    if not one.states:
        return added
    white = one.whitening(np.concatenate([one.signals[: one.states], added]))
    taken = np.linalg.lstsq(white[: one.states].T, white[one.states :].T, rcond=None)[0]
    return np.asarray(added - taken.T @ one.signals[: one.states])
