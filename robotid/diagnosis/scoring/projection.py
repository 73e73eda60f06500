"""All segments at once: whitened, and projected on the complement of what the fit has shaped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate
from robotid.diagnosis.scoring.scan import Scan
from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Projected:
    """Residual and candidates' columns in a space that keeps every inner product.

    missing (d, q) and residual (d,) : projected; whole (e, q) : the columns before projection; fitted (k, k) and shaped
    (k, q + 1) : a factor of the fitted parameters' columns, and the part of the others, last of the residual, that lies
    along them.
    """

    missing: Array
    residual: Array
    whole: Array
    fitted: Array
    shaped: Array

    @property
    def length(self) -> Array:
        """Length of the columns before projection, (q,)."""
        return np.asarray(np.linalg.norm(self.whole, axis=0))

    @property
    def energy(self) -> float:
        """Energy of the projected residual, in variances of the noise."""
        return float(self.residual @ self.residual)

    def moved(self, amplitude: Array, at: slice) -> Array:
        """How far the fitted parameters go, (k,), with these amplitudes of the columns `at`."""
        goal = self.shaped[:, -1] - self.shaped[:, at] @ amplitude
        length = np.linalg.norm(self.fitted, axis=0)
        scale = np.where(length > 0, length, 1.0)  # stiffness and inertia are many powers of ten apart
        return np.asarray(np.linalg.lstsq(self.fitted / scale, goal, rcond=SCORING.dependent)[0] / scale)


def project(scans: Sequence[Scan], changes: Sequence[RecordChangeCandidate] = ()) -> Projected:
    """Every segment whitened, its first states and then, for all at once, the fitted parameters taken out.

    changes : their columns are those of fitted parameters, on the segments of one record, and follow all others.
    """
    columns = scans[0].unknowns.parameters
    repeated = [(one.record, columns.index(one.column)) for one in changes]
    factor = np.zeros((0, 0))
    for one in scans:
        own = np.asarray(np.linalg.qr(one.whitened.T, mode="r"))[one.states :, one.states :]
        if repeated:
            more = [own[:, k] * (one.segment.record.name == name) for name, k in repeated]
            own = np.insert(own, [-1], np.stack(more, axis=1), axis=1)
        factor = np.asarray(own if not factor.size else np.linalg.qr(np.vstack([factor, own]), mode="r"))
    k = len(columns)
    return Projected(factor[k:, k:-1], factor[k:, -1], factor[:, k:-1], factor[:k, :k], factor[:k, k:])


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
