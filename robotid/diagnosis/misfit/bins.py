"""Bins for a curve over scattered samples."""

from __future__ import annotations

import numpy as np

from robotid.diagnosis.misfit.settings import MISFIT
from robotid.model.array import Array


def bin_edges(values: Array, signed: bool) -> Array:
    """Borders of bins, equally wide, equally full and finer towards zero, merged where one would hold too little.

    values (n,) -> (bins + 1,). signed : zero is a border.
    """
    low, high = float(values.min()), float(values.max())
    even = [np.quantile(values, np.linspace(0, 1, MISFIT.bins + 1)), np.linspace(low, high, MISFIT.bins + 1)]
    if signed:
        sides = [part for part in (values[values < 0], values[values > 0]) if part.size]
        even = [np.quantile(part, np.linspace(0, 1, MISFIT.bins // 2 + 1)) for part in sides]
        even += [np.linspace(0.0, part[np.argmax(np.abs(part))], MISFIT.bins // 2 + 1) for part in sides]
        even += [part[np.argmax(np.abs(part))] * np.geomspace(MISFIT.finest_bin, 1, MISFIT.bins // 2) for part in sides]
    borders = np.unique(np.concatenate([*even, [low, high]]))
    return _merged(borders, np.sort(values), 0.0 if signed and low < 0 < high else None)


def _merged(edges: Array, ordered: Array, border: float | None) -> Array:
    """Only those edges that leave enough samples between them, and the border."""
    least = max(1.0, MISFIT.least_bin_share * len(ordered))
    rank = np.searchsorted(ordered, edges)
    kept = [0]
    for k in range(1, len(edges) - 1):
        if edges[k] == border:
            while len(kept) > 1 and rank[k] - rank[kept[-1]] < least:
                kept.pop()
            kept.append(k)
        elif rank[k] - rank[kept[-1]] >= least:
            kept.append(k)
    while len(kept) > 1 and rank[-1] - rank[kept[-1]] < least and edges[kept[-1]] != border:
        kept.pop()
    return edges[[*kept, len(edges) - 1]]
