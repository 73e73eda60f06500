"""The conditions on which a cause is accepted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Criteria:
    """level : of significance of a whole search; worth : least RMS misfit that a cause must remove on held-out records,
    in noise standard deviations; refits : effects refitted a round; causes : most of them; skip : effects that are out
    of the question."""

    level: float = 1e-3
    worth: float = 0.1
    refits: int = 5
    causes: int = 4
    skip: tuple[str, ...] = ()
