"""Which missing effect would explain a residual: every candidate scored at its null, without a refit.

The residual and the candidates' columns are whitened and projected on the complement of what the fit has shaped; what
is left of the residual is explained by a candidate as far as its columns reach (the score test; Rao 1948).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import repeat

import numpy as np
import scipy

from robotid.diagnosis.noise.whitening import Whitening
from robotid.diagnosis.scoring.candidates import Candidate
from robotid.diagnosis.scoring.columns import columns
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array
from robotid.signals.record import Quantity, Record
from robotid.simulation.trajectory import Trajectory

DEPENDENT = 1e-6  # of a column's length left after projection: less is the same as nothing
NEGLIGIBLE = 1e-10  # relative singular value of the saturated regression


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One record with all its columns. signals (m, n) : to the first states, to the fitted parameters, to the
    candidates' parameters, to further forces, and last the residual; states, fitted : how many of the first two."""

    record: Record
    trajectory: Trajectory
    signals: Array
    states: int
    fitted: int

    @property
    def residual(self) -> Array:
        return np.asarray(self.signals[-1])

    @property
    def segment(self) -> SimulatedSegment:
        return SimulatedSegment(self.record, self.trajectory, self.residual)


@dataclass(frozen=True, slots=True, eq=False)
class Projected:
    """All records together, whitened and projected. missing (d, q) and residual (d,) keep every inner product;
    whole (e, q) : the columns before projection; fitted (k, k) and shaped (k, q + 1) : a factor of the fitted
    parameters' columns, and the part of the others, last of the residual, that lies along them."""

    missing: Array
    residual: Array
    whole: Array
    fitted: Array
    shaped: Array

    @property
    def length(self) -> Array:
        """Of the columns before projection, (q,)."""
        return np.asarray(np.linalg.norm(self.whole, axis=0))

    @property
    def energy(self) -> float:
        return float(self.residual @ self.residual)

    def moved(self, amplitude: Array, at: slice) -> Array:
        """How far the fitted parameters go, (k,), with these amplitudes of the columns `at`."""
        goal = self.shaped[:, -1] - self.shaped[:, at] @ amplitude
        length = np.linalg.norm(self.fitted, axis=0)
        scale = np.where(length > 0, length, 1.0)  # stiffness and inertia are many powers of ten apart
        return np.asarray(np.linalg.lstsq(self.fitted / scale, goal, rcond=DEPENDENT)[0] / scale)


@dataclass(frozen=True, slots=True)
class Score:
    """What a candidate explains: energy of the whitened residual, in noise variances; amplitude of each of its
    parameters. directions : its columns, orthonormal, in the space of `Projected`; moved (k,) : how far the fitted
    parameters go with it."""

    candidate: Candidate
    energy: float
    amplitude: tuple[float, ...]
    directions: Array
    moved: Array


def scan(
    segment: SimulatedSegment,
    output: Quantity,
    fitted: Sequence[int],
    free_states: Sequence[int],
    missing: Sequence[Candidate],
    more: Array | None = None,
) -> Scan:
    """All columns of one record. more (nv, m, n) : further forces."""
    found = columns(segment.trajectory, segment.record, output, fitted, free_states, missing, more)
    k = len(fitted)
    signals = np.concatenate([found.known[k:], found.known[:k], found.missing, found.more, segment.residual[None]])
    return Scan(segment.record, segment.trajectory, signals, len(free_states), k)


def scans(
    segments: Sequence[SimulatedSegment],
    output: Quantity,
    fitted: Sequence[int],
    free_states: Sequence[int],
    missing: Sequence[Candidate],
    more: Sequence[Array] | None = None,
) -> tuple[Scan, ...]:
    """All columns of every record. more : further forces, (nv, m, n) each; the rest as of `scan`."""
    return tuple(
        scan(segment, output, fitted, free_states, missing, force)
        for segment, force in zip(segments, more or repeat(None), strict=False)
    )


def unexplained(one: Scan) -> Array:
    """What is left of a residual (n,) when everything there is may explain it."""
    known, residual = one.signals[:-1], one.residual
    length = np.linalg.norm(known, axis=1)
    scaled = known[length > 0] / length[length > 0, None]
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    kept = values > NEGLIGIBLE * values[-1]
    basis = vectors[:, kept] / np.sqrt(values[kept])
    return np.asarray(residual - (basis @ (basis.T @ (scaled @ residual))) @ scaled)


def project(
    scans: Sequence[Scan], whitenings: Sequence[Whitening], differences: Sequence[tuple[str, int]] = ()
) -> Projected:
    """Every record whitened, its first states and then, for all records at once, the fitted parameters taken out.
    differences : records and fitted parameters, by number, of further columns: a parameter that is another in one
    record."""
    factor = np.zeros((0, 0))
    for one, whiten in zip(scans, whitenings, strict=True):
        own = np.asarray(np.linalg.qr(whiten(one.signals).T, mode="r"))[one.states :, one.states :]
        if differences:
            more = [own[:, k] * (one.record.name == name) for name, k in differences]
            own = np.insert(own, [-1], np.stack(more, axis=1), axis=1)
        factor = np.asarray(own if not factor.size else np.linalg.qr(np.vstack([factor, own]), mode="r"))
    k = scans[0].fitted
    return Projected(factor[k:, k:-1], factor[k:, -1], factor[:, k:-1], factor[:k, :k], factor[:k, k:])


def left_over(scans: Sequence[Scan], whitenings: Sequence[Whitening]) -> list[Array]:
    """The whitened residual of each record, (n,), less what first states and fitted parameters could still take."""
    bare = [
        replace(one, signals=np.concatenate([one.signals[: one.states + one.fitted], one.residual[None]]))
        for one in scans
    ]
    whole = project(bare, whitenings)
    moved = whole.moved(np.zeros(0), slice(0, 0))
    found = []
    for one, whiten in zip(bare, whitenings, strict=True):
        signals = whiten(one.signals)
        found.append(beyond(signals[-1] - moved @ signals[one.states : -1], signals[: one.states]))
    return found


def beyond(signal: Array, others: Array) -> Array:
    """What of a signal (n,) lies along none of the others (k, n)."""
    basis = np.linalg.qr(others.T)[0]
    return np.asarray(signal - basis @ (basis.T @ signal))


def score(projected: Projected, missing: Sequence[Candidate]) -> list[Score]:
    """Every candidate by itself, best first."""
    found, first = [], 0
    for candidate in missing:
        last = first + len(candidate.scored)
        found.append(_score(projected, candidate, slice(first, last)))
        first = last
    return sorted(found, key=lambda s: -s.energy)


def _score(projected: Projected, candidate: Candidate, at: slice) -> Score:
    own, length = projected.missing[:, at], np.linalg.norm(projected.whole[:, at], axis=0)
    nothing = Score(candidate, 0.0, (0.0,) * own.shape[1], np.zeros((len(own), 0)), np.zeros(len(projected.fitted)))
    left = np.linalg.norm(own, axis=0)
    if not np.all(left > DEPENDENT * length) or not length.all():
        return nothing
    q, r = np.linalg.qr(own / left)
    along = q.T @ projected.residual
    amplitude = np.linalg.lstsq(r, along, rcond=None)[0] / left
    if not _possible(candidate, amplitude):
        return nothing
    return Score(candidate, float(along @ along), tuple(amplitude.tolist()), q, projected.moved(amplitude, at))


def _possible(candidate: Candidate, amplitude: Array) -> bool:
    """Whether no parameter would have to leave its bounds at the null."""
    for k, a in zip(candidate.scored, amplitude.tolist(), strict=True):
        parameter = candidate.effect.parameters[k]
        if (a < 0 and parameter.bounds[0] == parameter.null) or (a > 0 and parameter.bounds[1] == parameter.null):
            return False
    return True


def significance(energy: float, parameters: int, total: float, samples: int, tries: int) -> float:
    """p-value of an explained energy by the F-test, for the best of so many tries."""
    rest = max(total - energy, 1e-300) / max(1, samples - parameters)
    return float(min(1.0, tries * scipy.stats.f.sf(energy / parameters / rest, parameters, samples)))
