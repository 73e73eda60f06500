"""Which combinations of parameters a torque depends on at all: the base parameters.

Of the columns of the regressor a QR factorisation with column pivoting picks as many independent ones as there are; the
others are combinations of these, and each base parameter is the picked one plus its share of the others (Gautier 1991).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular

from robotid.model.array import Array

RANK_TOLERANCE = 1e-9  # of the diagonal of R against its largest entry: rounding lies below, dependence above nothing
MIN_SHARE = 1e-7  # a share of another parameter below which rounding made it


@dataclass(frozen=True, slots=True, eq=False)
class BaseParameters:
    """picked (b,) : positions of the columns that stay. grouping (b, p) : base = grouping @ all parameters."""

    picked: tuple[int, ...]
    grouping: Array

    def names(self, symbols: Sequence[str], terms: int = 4) -> tuple[str, ...]:
        """Each base parameter as a sum of symbols (p,), the largest shares first, at most so many of them."""
        return tuple(_sum(row, k, symbols, terms) for k, row in zip(self.picked, self.grouping, strict=True))


def base_parameters(columns: Array) -> BaseParameters:
    """The base parameters of columns (n, p) at motions that excite all that can be excited."""
    p = columns.shape[1]
    norms = np.linalg.norm(columns, axis=0)
    acting = np.flatnonzero(norms > RANK_TOLERANCE * norms.max(initial=0.0))
    if not len(acting):
        return BaseParameters((), np.zeros((0, p)))
    _, r, order = qr(columns[:, acting] / norms[acting], mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(r))
    rank = int(np.sum(diagonal > RANK_TOLERANCE * diagonal[0]))
    shares = solve_triangular(r[:rank, :rank], r[:rank, rank:])
    picked, rest = acting[order[:rank]], acting[order[rank:]]
    grouping = np.zeros((rank, p))
    grouping[np.arange(rank), picked] = 1.0
    grouping[:, rest] = shares * norms[rest] / norms[picked][:, None]
    grouping[np.abs(grouping) < MIN_SHARE] = 0.0
    in_order = np.argsort(picked)
    return BaseParameters(tuple(int(k) for k in picked[in_order]), grouping[in_order])


def _sum(shares: Array, own: int, symbols: Sequence[str], terms: int) -> str:
    others = [k for k in np.argsort(-np.abs(shares), kind="stable").tolist() if shares[k] != 0.0 and k != own]
    text = symbols[own]
    for k in others[: terms - 1]:
        size = abs(float(shares[k]))
        factor = "" if abs(size - 1.0) < MIN_SHARE else f"{size:.3g} "
        text += f" {'-' if shares[k] < 0 else '+'} {factor}{symbols[k]}"
    return text + (" + ..." if len(others) >= terms else "")
