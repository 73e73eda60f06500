"""The criteria by which an effect is accepted as a cause."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Criteria:
    """What the user of a diagnosis demands of a cause.

    significance : level of significance of a whole round of the search, over all candidates.
    min_improvement_sigma : least RMS misfit that a cause must remove on the validation records, in standard deviations
    of the noise; on the fitted ones where there are no others.
    max_refits : most effects that are refitted in full in one round. max_causes : most causes that are named.
    skip : effects that are out of the question, with their place ("motor.cogging") or without ("cogging").
    """

    significance: float = 1e-3
    min_improvement_sigma: float = 0.1
    max_refits: int = 5
    max_causes: int = 4
    skip: tuple[str, ...] = ()
