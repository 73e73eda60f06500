"""Tuning constants of refits."""

from __future__ import annotations

from dataclasses import dataclass

from robotid.estimate.residual import TRIAL_PATIENCE


@dataclass(frozen=True, slots=True)
class RefitSettings:
    """How long and how exactly a model is refitted."""

    unidentifiable: float = 1e-9  # smallest singular value of the scaled Jacobian that counts as information
    patience: int = TRIAL_PATIENCE  # windows that may fail to settle
    max_iterations: int = 12  # of the fit; one that is on its way needs half of them
    further_iterations: int = 28  # of one that is in a narrow valley, where little noise is known
    steady: float = 0.03  # of the cost, which each of these must lower it by
    tolerance: float = 1e-4  # of the cost: least decrease that is worth another step
    careful_tolerance: float = 1e-5  # the same for the model that is diagnosed, once little misfit is left
    hopeless_start: float = 20.0  # times the energy that is low enough: a start that leaves more is none
    misfit_tolerance: float = 3e-3  # of the misfit: a step that gains less is not worth it while there is so much of it
    little_misfit: float = 0.5  # of a model's energy: with less misfit its parameters are worth the finest steps
    max_validation_iterations: int = 8  # for the first states of a validation record
    validation_tolerance: float = 1e-4  # of the cost on a validation record
    pieces: int = 8  # of each record, for multiple shooting: over an eighth of it little goes astray


REFIT = RefitSettings()
