"""All segments at once: whitened, and projected on the complement of what the fit has shaped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.scoring.blocked_regression import BlockedRegression, blocked, blocked_beside, together
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate
from robotid.diagnosis.scoring.scan import Scan
from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Projected:
    """Residual and candidates' columns in a space that keeps every inner product.

    missing (d, q) and residual (d,) : projected; whole (e, q) : the columns before projection; fitted (k, k) and shaped
    (k, q + 1) : a factor of the fitted parameters' columns, and the part of the others, last of the residual, that lies
    along them; blocks : the regression of the residual on the k + q columns, block of time by block of time.
    """

    missing: Array
    residual: Array
    whole: Array
    fitted: Array
    shaped: Array
    blocks: BlockedRegression

    @property
    def length(self) -> Array:
        """Length of the columns before projection, (q,)."""
        return np.asarray(np.linalg.norm(self.whole, axis=0))

    @property
    def energy(self) -> float:
        """Energy of the projected residual, in variances of the noise."""
        return float(self.residual @ self.residual)

    def visible_length(self, at: slice) -> float:
        """Length that one unit of the columns `at` leaves after projection, zero where nothing is left. Several, as of
        sine and cosine, count as one in any proportion."""
        left = np.linalg.norm(self.missing[:, at], axis=0)
        visible = np.where(left > SCORING.dependent * np.linalg.norm(self.whole[:, at], axis=0), left, 0.0)
        return float(np.sqrt(np.mean(np.square(visible))))

    def moved(self, amplitude: Array, at: slice) -> Array:
        """How far the fitted parameters go, (k,), with these amplitudes of the columns `at`."""
        goal = self.shaped[:, -1] - self.shaped[:, at] @ amplitude
        length = np.linalg.norm(self.fitted, axis=0)
        scale = np.where(length > 0, length, 1.0)  # stiffness and inertia are many powers of ten apart
        return np.asarray(np.linalg.lstsq(self.fitted / scale, goal, rcond=SCORING.dependent)[0] / scale)

    def beside_fitted(self, at: slice) -> BlockedRegression:
        """The regression on the fitted parameters and, after them, the columns `at`."""
        k = len(self.fitted)
        return self.blocks.take([*range(k), *range(k + at.start, k + at.stop)])


def project(scans: Sequence[Scan], changes: Sequence[RecordChangeCandidate] = ()) -> Projected:
    """Every segment whitened, its first states and then, for all at once, the fitted parameters taken out.

    changes : their columns are those of fitted parameters, on the segments of one record, and follow all others.
    """
    columns = scans[0].unknowns.parameters
    changed = [(one.record, columns.index(one.column)) for one in changes]
    samples = sum(one.signals.shape[1] for one in scans)
    parts = [_blocks_without_states(one, samples / SCORING.blocks) for one in scans]
    blocks = together([_with_changes(part, one, changed) for part, one in zip(parts, scans, strict=True)])
    factor, k = _factor(blocks), len(columns)
    return Projected(factor[k:, k:-1], factor[k:, -1], factor[:, k:-1], factor[:k, :k], factor[:k, k:], blocks)


def without_states(one: Scan) -> Array:
    """The columns of a segment through its whitening, less what its first states take: those of fitted parameters, and
    all that follow, (k, n)."""
    white = one.whitened
    if not one.states:
        return white[:-1]
    basis = np.linalg.qr(white[: one.states].T)[0]
    columns = white[one.states : -1]
    return np.asarray(columns - (columns @ basis) @ basis.T)


def _blocks_without_states(one: Scan, length: float) -> BlockedRegression:
    """The regression of a segment's residual on all its columns, less what its first states take of either."""
    white = one.whitened
    if not one.states:
        return blocked(white[:-1], white[-1], length)
    basis = np.linalg.qr(white[: one.states].T)[0]
    return blocked_beside(basis, white[one.states :], length, SCORING.dependent)


def _with_changes(part: BlockedRegression, one: Scan, changed: Sequence[tuple[str, int]]) -> BlockedRegression:
    """With the columns of fitted parameters once more, those of other records' changes zero."""
    if not changed:
        return part
    at = np.array([*range(part.moment.shape[1]), *(k for _, k in changed)])
    there = np.array([name == one.segment.record.name for name, _ in changed], dtype=np.float64)
    share = np.concatenate([np.ones(part.moment.shape[1]), there])
    information = part.information[:, at[:, None], at] * np.outer(share, share)
    return BlockedRegression(information, part.moment[:, at] * share, part.energy)


def _factor(blocks: BlockedRegression) -> Array:
    """Upper triangular R, R^T R being the products of all columns and, last, the residual."""
    information, moment = blocks.information.sum(axis=0), blocks.moment.sum(axis=0)
    products = np.block([[information, moment[:, None]], [moment[None], blocks.energy.sum()[None, None]]])
    length = np.sqrt(np.maximum(np.diag(products), 0.0))
    scale = np.where(length > 0.0, length, 1.0)
    values, vectors = np.linalg.eigh(products / np.outer(scale, scale))
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T * length
    return np.asarray(np.linalg.qr(root, mode="r"))


def left_over(scans: Sequence[Scan]) -> list[Array]:
    """The whitened residual of each segment, (n,), less what first states and fitted parameters could still take."""
    bare = [one.bare for one in scans]
    moved = project(bare).moved(np.zeros(0), slice(0, 0))
    found = []
    for one in bare:
        signals = one.whitened
        found.append(beyond(signals[-1] - moved @ signals[one.states : -1], signals[: one.states]))
    return found


def beyond(signal: Array, others: Array) -> Array:
    """What of a signal (n,) lies along none of the others (k, n)."""
    basis = np.linalg.qr(others.T)[0]
    return np.asarray(signal - basis @ (basis.T @ signal))
