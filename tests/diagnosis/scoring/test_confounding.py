"""What answers like a cause stands beside it, at its most similar shape."""

from __future__ import annotations

import numpy as np
import pytest
from support.plain_models import plain_blocks

from robotid.diagnosis.scoring.candidate import Candidate
from robotid.diagnosis.scoring.catalogue_candidates import term_candidate
from robotid.diagnosis.scoring.confounding import confounded_with
from robotid.diagnosis.scoring.projection import Projected
from robotid.diagnosis.scoring.score_test import Score
from robotid.model.port import Port
from robotid.terms import TERMS

RESIDUAL = np.array([10.0, 0.0, 0.0])
PROJECTED = Projected(np.zeros((3, 0)), RESIDUAL, np.zeros((3, 0)), np.zeros((0, 0)), np.zeros((0, 1)), plain_blocks(0))


def scored(effect: str, *values: float, angle: float) -> Score:
    """A candidate whose only direction lies at an angle to the residual."""
    candidate: Candidate = term_candidate(Port.MOTOR, TERMS[effect], values)
    direction = np.array([[np.cos(angle)], [np.sin(angle)], [0.0]])
    return Score(candidate, float(direction[:, 0] @ RESIDUAL) ** 2, (1.0,), direction, np.zeros(0))


def test_the_most_similar_shape_counts_and_the_unlike_are_left_out() -> None:
    best = scored("quadratic_friction", 0.0, angle=0.0)
    others = (
        scored("stribeck", 0.0, 1.0, angle=0.6),
        scored("stribeck", 0.0, 3.0, angle=0.3),
        scored("power_friction", 0.0, 0.5, angle=-0.1),
        scored("asymmetric_coulomb", 0.0, angle=1.5),
    )
    found = confounded_with(best, PROJECTED, (best, *others))
    assert [one.effect for one in found] == ["motor.power_friction", "motor.stribeck"]
    assert [one.correlation for one in found] == pytest.approx([np.cos(0.1), np.cos(0.3)])


def test_what_explains_nothing_is_like_nothing() -> None:
    best = scored("quadratic_friction", 0.0, angle=np.pi / 2)
    assert confounded_with(best, PROJECTED, (best, scored("stribeck", 0.0, 1.0, angle=0.0))) == ()
