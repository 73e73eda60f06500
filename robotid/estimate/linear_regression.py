"""Linear least squares over several records, with its uncertainty; and when the columns do not allow it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from robotid.errors import NumericsError
from robotid.estimate.covariance import coloured_information
from robotid.model.array import Array

MAX_CONDITION = 1e3  # of the columns scaled to unit norm; beyond, friction and filter errors decide the estimate
MIN_SAMPLES_PER_PARAMETER = 5
MAX_PASSES = 10  # in which the blocks' weights settle
HINT = "record a motion that excites them, fix some of them, or leave effects out of the model"


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """One record: tau (n,) = columns^T theta + error, columns (p, n)."""

    columns: Array
    tau: Array


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Lower and upper bounds of theta, (p,) each."""

    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """theta (p,); weights, one a block; covariance for white errors and for errors as coloured as they are, (p, p);
    residuals (n,) a block; condition number of the columns scaled to unit norm."""

    theta: Array
    weights: Array
    covariance: Array
    covariance_robust: Array
    residuals: tuple[Array, ...]
    condition_number: float


def solve(names: Sequence[str], blocks: Sequence[Block]) -> Solution:
    """Least squares, each block weighted by its own residual in the end, so that a poor one does not spoil the others.

    Raises NumericsError, with the parameters' names, where the columns do not determine them, and where a block is
    empty.
    """
    if not all(len(b.tau) for b in blocks):
        raise NumericsError("nothing is left of a record", hint="record a longer motion")
    _require_excitation(names, np.hstack([b.columns for b in blocks]))
    weights = np.ones(len(blocks))
    theta = _minimise(blocks, weights)
    for _ in range(MAX_PASSES if len(blocks) > 1 else 0):
        rms = np.array([np.sqrt(np.mean((b.tau - theta @ b.columns) ** 2)) for b in blocks])
        weights = 1.0 / np.maximum(rms, 1e-6 * max(np.ptp(b.tau) for b in blocks))
        theta = _minimise(blocks, weights)
    return _with_uncertainty(theta, blocks, weights)


def solve_within(blocks: Sequence[Block], solution: Solution, limits: Limits) -> Array:
    """The least squares of a solution within limits, theta (p,): what stops at a limit changes the others, too, and is
    at the limit to the last bit."""
    theta = solution.theta
    if np.all((limits.lower <= theta) & (theta <= limits.upper)):
        return theta
    columns, tau = _stack(blocks, solution.weights)
    scale = np.linalg.norm(columns, axis=1)
    within = lsq_linear((columns / scale[:, None]).T, tau, (limits.lower * scale, limits.upper * scale))
    stops = [within.active_mask < 0, within.active_mask > 0]
    return np.asarray(np.select(stops, [limits.lower, limits.upper], within.x / scale))


def relative_error(residual: Array, tau: Array) -> float:
    """100 ||residual|| / ||tau|| [%]."""
    scale = float(np.linalg.norm(tau))
    return 100.0 * float(np.linalg.norm(residual)) / scale if scale > 0 else 0.0


def _minimise(blocks: Sequence[Block], weights: Array) -> Array:
    columns, tau = _stack(blocks, weights)
    scale = np.linalg.norm(columns, axis=1)
    return np.asarray(np.linalg.lstsq((columns / scale[:, None]).T, tau, rcond=None)[0] / scale)


def _stack(blocks: Sequence[Block], weights: Array) -> tuple[Array, Array]:
    """All weighted columns (p, n) and torques (n,)."""
    columns = np.hstack([w * b.columns for w, b in zip(weights, blocks, strict=True)])
    return columns, np.concatenate([w * b.tau for w, b in zip(weights, blocks, strict=True)])


def _with_uncertainty(theta: Array, blocks: Sequence[Block], weights: Array) -> Solution:
    residuals = tuple(b.tau - theta @ b.columns for b in blocks)
    columns = [w * b.columns for w, b in zip(weights, blocks, strict=True)]
    errors = [w * e for w, e in zip(weights, residuals, strict=True)]
    stacked = np.hstack(columns)
    scale = np.linalg.norm(stacked, axis=1)
    inverse = np.linalg.inv((stacked / scale[:, None]) @ (stacked / scale[:, None]).T) / np.outer(scale, scale)
    variance = sum(float(e @ e) for e in errors) / (stacked.shape[1] - len(theta))
    middle = sum((coloured_information(c, e) for c, e in zip(columns, errors, strict=True)), np.zeros_like(inverse))
    condition = float(np.linalg.cond(stacked / scale[:, None]))
    return Solution(theta, weights, variance * inverse, inverse @ middle @ inverse, residuals, condition)


def too_few(columns: Array) -> bool:
    """Whether columns (p, n) have too few samples to regress on."""
    return bool(columns.shape[1] < MIN_SAMPLES_PER_PARAMETER * max(1, len(columns)))


def _require_excitation(names: Sequence[str], columns: Array) -> None:
    if too_few(columns):
        raise NumericsError(
            f"{columns.shape[1]} filtered samples are too few for {len(names)} parameters",
            where="init_rigid",
            hint="record for longer, raise cutoff or lower min_speed",
        )
    norms = np.linalg.norm(columns, axis=1)
    still = [name for name, norm in zip(names, norms, strict=True) if norm == 0]
    if still:
        raise NumericsError(f"the records do not excite {', '.join(still)}", where="init_rigid", hint=HINT)
    _, values, directions = np.linalg.svd((columns / norms[:, None]).T, full_matrices=False)
    if values[-1] * MAX_CONDITION <= values[0]:
        together = [name for name, part in zip(names, directions[-1], strict=True) if abs(part) > 0.1]
        raise NumericsError(f"the records cannot tell {' from '.join(together)}", where="init_rigid", hint=HINT)
