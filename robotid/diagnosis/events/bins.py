"""The answer of the output to a torque in every short stretch of a record, beyond what is known.

Each bin of time has two columns, of a torque at the motor and of one against the motion. The answer to a longer event
is the sum of those of its bins, and so are all inner products: one banded solve a record serves for every event. What
the fitted parameters, and on demand all effects of the catalogue, could take is projected out for all records at once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.events.applied import direction
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.refit.refitted_model import Unknowns
from robotid.diagnosis.scoring.columns import columns
from robotid.diagnosis.scoring.scan import Scan
from robotid.model.array import Array
from robotid.model.derivatives import DerivativeColumns
from robotid.simulation.friction.step import Steps
from robotid.simulation.trajectory import linearised_each


@dataclass(frozen=True, slots=True, eq=False)
class BinnedRecord:
    """All bins of one record, in order of time.

    edges (B + 1,) : of the bins [s]. product (2, B, 2, B) and moment (2, B) : inner products of the columns, of torque
    and of friction, with each other and with the residual, what is known projected out; taken (2, B, m) : what of each
    lay along what is known, by which bins of different records are connected; whole (2, B) : squared length of the
    columns before.
    """

    record: str
    edges: Array
    product: Array
    moment: Array
    taken: Array
    whole: Array

    @property
    def count(self) -> int:
        """Number of bins."""
        return len(self.edges) - 1

    def along(self, event: BinnedRecord, column: int, weights: Array) -> Array:
        """Inner products (2, B) of all columns with those of an event, of bins (B',) of the same or another record."""
        if event.record == self.record:
            return np.asarray(np.einsum("aibj,j->aib", self.product, weights)[:, :, column])
        return np.asarray(-self.taken @ (weights @ event.taken[column]))

    def without(self, event: BinnedRecord, column: int, weights: Array) -> BinnedRecord:
        """The same with an event projected out. column : 0 of torque, 1 of friction; weights : of the event's bins."""
        size = float(weights @ event.product[column, :, column] @ weights)
        along = self.along(event, column, weights)
        moment = self.moment - float(weights @ event.moment[column]) / size * along
        product = self.product - np.einsum("ai,bj->aibj", along, along) / size
        return replace(self, product=product, moment=moment)


def even_edges(scans: Sequence[Scan], record: str) -> Array:
    """Borders of bins of equal length over all segments of a record [s]."""
    own = [one.segment.record for one in scans if one.segment.record.name == record]
    return np.linspace(own[0].begin, own[-1].begin + own[-1].duration, EVENTS.bins + 1)


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known of every segment, its first states projected out: known (m, n) columns and residual (n,) of each,
    and for all together a basis (m, r) in which they are orthonormal, and the residual's part along it (r,). steps : of
    each, with the derivatives to forces."""

    scans: tuple[Scan, ...]
    steps: tuple[Steps, ...]
    known: tuple[Array, ...]
    residuals: tuple[Array, ...]
    basis: Array
    moment: Array

    @property
    def misfit(self) -> float:
        """Energy of all residuals that lies along nothing known, beyond that of noise, in variances of it."""
        way = self.basis @ self.moment
        left = (residual - way @ own for own, residual in zip(self.known, self.residuals, strict=True))
        return sum(float(one @ one) - len(one) for one in left)


def steps_of(scans: Sequence[Scan]) -> tuple[Steps, ...]:
    """The steps of every segment, with the derivatives to forces."""
    masses = scans[0].segment.trajectory.joint.masses
    wanted = DerivativeColumns(forces=tuple(range(masses)))
    return tuple(linearised_each([one.segment.trajectory for one in scans], wanted))


def known_columns(scans: Sequence[Scan], steps: Sequence[Steps], *, catalogue: bool) -> Known:
    """The columns of the fitted parameters; and, where the catalogue is to be known, too, those of all its effects, and
    of the parameters as different in every record. steps : as of `steps_of`."""
    columns_of, residuals = [], []
    names = list(dict.fromkeys(one.segment.record.name for one in scans))
    for one in scans:
        whitened = one.whitened
        own = _beyond_all(whitened[one.states :], whitened[: one.states])
        parameters = own[: len(one.unknowns.parameters)]
        if catalogue:
            changed = [(name == one.segment.record.name) * parameters for name in names[1:]]
            columns_of.append(np.concatenate([own[:-1], *changed]))
        else:
            columns_of.append(parameters)
        residuals.append(own[-1])
    pairs = list(zip(columns_of, residuals, strict=True))
    total = np.sum([own @ own.T for own, _ in pairs], axis=0)
    moment = np.sum([own @ left for own, left in pairs], axis=0)
    basis = _basis(total)
    return Known(tuple(scans), tuple(steps), tuple(columns_of), tuple(residuals), basis, basis.T @ moment)


def binned(known: Known, edges: Mapping[str, Array]) -> list[BinnedRecord]:
    """The bins of every record that has edges, what is known projected out."""
    parts: dict[str, list[tuple[Array, Array, Array]]] = {name: [] for name in edges}
    for one, steps, columns_of, residual in zip(known.scans, known.steps, known.known, known.residuals, strict=True):
        name = one.segment.record.name
        if name in edges:
            own = _answers(one, steps, edges[name])
            parts[name].append((own @ own.T, own @ residual, own @ columns_of.T))
    return [_joined(name, edges[name], found, known) for name, found in parts.items()]


def _joined(name: str, edges: Array, parts: Sequence[tuple[Array, Array, Array]], known: Known) -> BinnedRecord:
    """The segments of a record together; a bin of one has no answer in another, for every segment starts afresh."""
    product, own, across = (np.sum([part[k] for part in parts], axis=0) for k in range(3))
    whole, b = np.diag(product).reshape(2, -1), len(edges) - 1
    taken = across @ known.basis
    left, moment = product - taken @ taken.T, own - taken @ known.moment
    return BinnedRecord(
        name, edges, left.reshape(2, b, 2, b), moment.reshape(2, b), taken.reshape(2, b, taken.shape[1]), whole
    )


def _answers(one: Scan, steps: Steps, edges: Array) -> Array:
    """The whitened output's answer to a unit torque in each bin, and then to unit friction, (2 B, n), beyond the first
    states."""
    record, b = one.segment.record, len(edges) - 1
    t, h, found = record.t, record.sampling_time, np.zeros((2, b, len(record)))
    within = np.flatnonzero((edges[1:] > t[0]) & (edges[:-1] < t[-1] + h))  # the others have no answer here
    if not within.size:
        return found.reshape(2 * b, -1)
    begins, ends = edges[within, None], edges[within + 1, None]
    shares = np.clip(np.minimum(t + h, ends) - np.maximum(t, begins), 0.0, h) / h
    forces = np.zeros((one.segment.trajectory.joint.masses, 2 * within.size, len(record)))
    forces[0] = np.concatenate([shares, -direction(record.dphi_m) * shares])
    answers = columns(one.segment.trajectory, record, Unknowns(one.unknowns.output), (), forces, steps).forces
    own = _beyond_all(one.whitening(answers), one.whitening(one.signals[: one.states]))
    found[:, within] = own.reshape(2, within.size, -1)
    return found.reshape(2 * b, -1)


def _beyond_all(signals: Array, others: Array) -> Array:
    """What of each of the signals (m, n) lies along none of the others (k, n)."""
    if not len(others):
        return signals
    basis = np.linalg.qr(others.T)[0]
    return np.asarray(signals - (signals @ basis) @ basis.T)


def _basis(total: Array) -> Array:
    """Combinations (m, r) of columns with these inner products that are orthonormal, along all that they determine."""
    scale = np.sqrt(np.maximum(np.diag(total), 1e-300))
    values, vectors = np.linalg.eigh(total / np.outer(scale, scale))
    kept = values > EVENTS.dependent * max(values[-1], 1e-300) if len(values) else np.zeros(0, dtype=bool)
    return np.asarray(vectors[:, kept] / np.sqrt(values[kept]) / scale[:, None])
