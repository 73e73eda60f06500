"""Whether a cause is as large at all times: an imitator is not, nor is an event, nor a change between records.

The fitted effect as a whole is one regressor beside all other unknowns of the fit, at an amplitude of one. Its scores,
summed along the blocks of time, stray from zero by chance alone where the amplitude is constant (Nyblom 1989; Hansen
1992).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression
from robotid.diagnosis.search.coloured import Left
from robotid.diagnosis.search.physical_sense import amplitudes
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.step import Step
from robotid.model.array import Array

NEGLIGIBLE = 1e-12  # of the part that knows most of an effect: one that knows less knows nothing


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """An effect over the blocks of time. parts : its size in each part of the records, in sizes that the fit found;
    spread : of these, weighted by what each part knows of it; p_value : of one size throughout."""

    parts: Array
    spread: float
    p_value: float


def is_not_constant(step: Step, criteria: Criteria) -> str | None:
    """A cause must be about as large in all parts of the records."""
    for effect in step.added:
        course = course_of(step.after, effect, step.left)
        if course is not None and varies(course, criteria.significance):
            sizes = ", ".join(f"{100 * part:.0f}" for part in course.parts)
            return f"is not the same throughout: {sizes} % of its size in the parts of the records"
    return None


def varies(course: Course, significance: float) -> bool:
    """Whether an effect is not the same throughout: beyond chance, and by more than other misfits make it appear."""
    return course.p_value < significance and course.spread > ACCEPTANCE.constant_spread


def course_of(model: RefittedModel, effect: str, left: Left) -> Course | None:
    """An effect of a refitted model over its records; None where no amplitude of it was fitted. left : by the model."""
    sizes = amplitudes(model, effect)
    if not sizes:
        return None
    return course(left.blocks.combined(sizes))


def course(blocks: BlockedRegression) -> Course:
    """The last regressor of a regression on what a fit leaves, over time; its amplitude is one in all."""
    scores, information = blocks.scores_of(blocks.moment.shape[1] - 1)
    parts = min(ACCEPTANCE.constant_parts, len(scores))
    score, weight = (np.array([p.sum() for p in np.array_split(x, parts)]) for x in (scores, information))
    weight = np.maximum(weight, 0.0)  # of what other columns all but take, rounding may leave less than nothing
    visible = weight > NEGLIGIBLE * weight.max()
    apart = np.divide(score, weight, out=np.zeros_like(score), where=visible)
    spread = float(np.sqrt(np.sum(weight * apart**2) / weight.sum())) if visible.any() else 0.0
    return Course(1.0 + apart, spread, blocks.constancy(blocks.moment.shape[1] - 1))
