"""Derivatives of records span by span: a short record is one span, a long one several, so that memory stays within
limits.

The spans of a record count as independent: what an error of the torque in one of them does in the next is left out. A
record is therefore cut only where its joint has forgotten an error long before a span ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from robotid.estimate.covariance import impulse_response
from robotid.estimate.residual import Evaluation, OutputError
from robotid.model.array import Array

MAX_SAMPLES = 500_000  # of a span: its derivatives to ten unknowns take 40 MB, and their spectra four times that
FORGOTTEN = 0.01  # of the largest response to a torque, at the end of a span
SAMPLED_SPANS = 5  # of a long record, from which its noise is read off
SAMPLED = 100_000  # samples of each of them


@dataclass(frozen=True, slots=True, eq=False)
class Spans:
    """The spans of record k of a problem at an evaluation. cuts : of its samples."""

    problem: OutputError
    at: Evaluation
    k: int
    cuts: tuple[slice, ...]

    @classmethod
    def of(cls, problem: OutputError, at: Evaluation, k: int) -> Spans:
        """The record whole where it is short, or where its joint does not forget."""
        record = problem.records[k]
        n = len(record)
        edges = np.linspace(0, n, -(-n // MAX_SAMPLES) + 1).round().astype(int).tolist()
        if len(edges) > 2:
            joint, theta = problem.joint.along(record), problem.joint.in_record(problem.theta(at.unknowns), record.name)
            response = np.abs(impulse_response(joint, theta, problem.row, record.sampling_time, edges[1]))
            if response[-1] > FORGOTTEN * response.max():
                edges = [0, n]
        return cls(problem, at, k, tuple(slice(a, b) for a, b in pairwise(edges)))

    def derivatives(self) -> Iterator[tuple[slice, Array]]:
        """Each span with the derivatives of its weighted residual, (m, its samples). Raises as
        `OutputError.jacobian` does."""
        if len(self.cuts) == 1:
            yield self.cuts[0], self.problem.jacobian(self.at, self.k).values
            return
        left = list(self.cuts)
        parts: list[Array] = []
        for block, values in self.problem.derivative_blocks(self.at, self.k):
            first, part = block.start, values
            while part.shape[1]:
                taken = min(part.shape[1], left[0].stop - first)
                parts.append(part[:, :taken])
                first, part = first + taken, part[:, taken:]
                if first == left[0].stop:
                    yield left.pop(0), np.concatenate(parts, axis=1)
                    parts = []

    def sampled(self) -> Sequence[slice]:
        """The spans, of a long record the beginnings of a few of them, that tell of its noise."""
        if len(self.cuts) == 1:
            return self.cuts
        chosen = np.unique(np.linspace(0, len(self.cuts) - 1, SAMPLED_SPANS).round().astype(int))
        cuts = [self.cuts[k] for k in chosen]
        return [slice(one.start, min(one.stop, one.start + SAMPLED)) for one in cuts]
