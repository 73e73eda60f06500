"""What else answers like a cause: the correlation of its columns with those of other effects on the motions recorded.

Two effects whose answers are alike once the fitted parameters have taken what they can differ little, and a
misfit that one of them makes is nearly as well explained by the other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.diagnosis.results import Confounded
from robotid.diagnosis.scoring.projection import Projected
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array


def confounded_with(best: Score, projected: Projected, scores: Sequence[Score]) -> tuple[Confounded, ...]:
    """The effects that answer much like a score's, at their most similar shape, the most alike first."""
    answer = answer_of(best, projected)
    size = float(np.linalg.norm(answer))
    found: dict[str, float] = {}
    for one in scores:
        name = one.candidate.name
        if name != best.candidate.name and one.directions.size and size > 0.0:
            along = float(np.linalg.norm(one.directions.T @ answer)) / size
            found[name] = max(found.get(name, 0.0), min(1.0, along))
    alike = (Confounded(name, along) for name, along in found.items() if along > SCORING.confounded)
    return tuple(sorted(alike, key=lambda one: -one.correlation))


def answer_of(one: Score, projected: Projected) -> Array:
    """What a candidate explains of the projected residual, (d,)."""
    return np.asarray(one.directions @ (one.directions.T @ projected.residual))
