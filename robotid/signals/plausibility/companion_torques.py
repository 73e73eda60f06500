"""What the companions of a record do to its axis whatever that does: coupling, weight, torques that are recorded.

Each is the derivative, to one of its parameters, of an effect of the catalogue that reads the companion, on an axis
that neither turns nor accelerates. So what follows the axis' own motion is never taken for theirs.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from robotid.model.array import Array
from robotid.model.term import Motion, Term
from robotid.signals.record import Record
from robotid.terms import TERMS


def companion_torques(record: Record, angle: Array) -> Iterator[Array]:
    """Torques of the companions for one unit of each parameter, (n,) each. angle : of the arm [rad], (n,)."""
    still = np.zeros_like(angle)
    for name, one in record.companions.items():
        w, dw, ddw = record.courses[name].samples
        at_rest = Motion(angle, still, still, still, record.t, np.zeros((0, len(still))), w=w, dw=dw, ddw=ddw)
        for term in TERMS.values():
            if term.companion is one.kind and term.reads is None and not term.states:
                yield from _columns(term, at_rest)


def _columns(term: Term, at_rest: Motion) -> Iterator[Array]:
    """Derivatives of a term at its null to its parameters, but for shapes, at every point of their grids."""
    points = [p.grid if p.is_shape else (p.guess if p.null is None else p.null,) for p in term.parameters]
    for values in product(*points):
        for parameter, column in zip(term.parameters, term.partials(at_rest, values).theta, strict=True):
            if not parameter.is_shape and np.any(column):
                yield np.broadcast_to(np.asarray(column, dtype=np.float64), at_rest.x.shape)
