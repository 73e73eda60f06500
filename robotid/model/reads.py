"""Which arguments a term reads, found by its derivatives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from robotid.model.derivatives import absent
from robotid.model.term import Motion, Partials, Term


@dataclass(frozen=True, slots=True)
class Reads:
    """Which arguments a term reads at all."""

    x: bool
    a: bool
    s: bool


@lru_cache(maxsize=256)
def reads_of(term: Term) -> Reads:
    """What a term reads, by its derivatives at some point; found once of a term, for joints are assembled all the
    time."""
    point, zero = np.full(1, 0.3), np.zeros(1)
    m = Motion(point, point, zero, np.ones(1), point, np.full((len(term.states), 1), 0.3), point, point, point)
    m = replace(m, w=point, dw=point, ddw=point)
    p = [q.guess or min(1.0, q.bounds[1]) for q in term.parameters]
    partials: tuple[Partials, ...] = (term.partials(m, p), *term.rate_partials(m, p))
    return Reads(*(any(not absent(getattr(d, name)) for d in partials) for name in ("x", "a", "s")))
