"""What the causes leave unexplained: the curve that no effect explains, and causes that only imitate it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.nonparametric.curve_fit import FittedCurve, fit_acting, fit_acting_along, fit_curves
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import CAREFUL, refit
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.scoring.score_test import significance
from robotid.diagnosis.search.carry_over import gain_of_samples, together
from robotid.diagnosis.search.drawn_sizes import curve_p_value
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.state import (
    SearchResult,
    SearchState,
    is_plain,
    misfit_energy,
    share_removed,
)
from robotid.errors import NumericsError


def better_curve(state: SearchState, criteria: Criteria) -> FittedCurve | None:
    """The free curve that explains clearly more of the first model's misfit than all causes do, where these leave a
    curve that is no noise; or None, as where the first model cannot be fitted by the noise as it is now."""
    first, last, data = state.first, state.model, state.data
    if misfit_energy(first, data) <= 0.0 or state.misfit <= 0.0:
        return None
    try:
        again = refit(first.structure, [first.parameters], data, first.trajectories, CAREFUL)
    except NumericsError:
        return None
    explained = _least_share(again, data, again.energy - last.energy, again.validation_energy - last.validation_energy)
    if explains_enough(explained, data):
        return None
    curve = next(iter(fit_curves(again, data)), None)
    alone = len(last.structure.effects) == len(first.structure.effects) + 1
    if curve is None or stands(explained, curve.energy / max(again.energy - data.samples, 1e-9), data, alone=alone):
        return None
    curve = fit_acting(curve, again, data)
    curve_share = _least_share(again, data, curve.energy, curve.validation_energy)
    if stands(explained, curve_share, data, alone=alone) or not _leaves_a_curve(state, criteria):
        return None
    return curve


def _leaves_a_curve(state: SearchState, criteria: Criteria) -> bool:
    """Whether a free curve explains more than noise of any colour would of what the causes leave: one with many knots
    explains more than a law of few parameters by chance."""
    left = next(iter(fit_curves(state.model, state.data)), None)
    return left is not None and curve_p_value(state.model, left.basis.forces) <= criteria.significance


def explains_enough(explained: float, data: EvaluationData) -> bool:
    """Whether causes that explain this share of the misfit stand beside any curve."""
    return explained > (ACCEPTANCE.complete_share if data.noise_reached else ACCEPTANCE.imitation_share)


def _least_share(model: RefittedModel, data: EvaluationData, energy: float, validation_energy: float) -> float:
    """Share of a model's misfit that is explained, on the fitted or on the validation segments, whichever is less."""
    whole, validation = max(model.energy - data.samples, 1e-9), model.validation_energy - data.validation_samples
    return min(energy / whole, validation_energy / validation) if validation > 0.0 else energy / whole


def stands(explained: float, curve: float, data: EvaluationData, *, alone: bool) -> bool:
    """Whether causes stand that explain less than everything, beside a free curve that explains a share of the misfit.

    alone : there is one cause, which has fewer parameters than a curve; several must be clearly better than it.
    """
    if not data.noise_reached:
        return explained > ACCEPTANCE.imitation_share * curve
    return explained > curve + (-ACCEPTANCE.clear_share if alone else ACCEPTANCE.clear_share)


def is_complete(found: SearchResult) -> bool:
    """Whether nothing was named, and a free curve explains all of the misfit."""
    return not found.causes and found.curve is not None and found.curve_share > ACCEPTANCE.complete_share


def is_imitated(found: SearchResult, named: SearchResult) -> bool:
    """Whether causes only imitate the curve that another search found, by whose noise they are measured."""
    if found.curve is None:
        return False
    first, data = found.first, found.data
    explained = share_removed(first, first, named.last, data, plain=is_plain(first, data))
    return explained < ACCEPTANCE.imitation_share * found.curve_share


def with_unexplained(result: SearchResult, criteria: Criteria) -> SearchResult:
    """The result with the curve that explains most of what its causes leave, where that is worth a word."""
    data, whole = result.data, misfit_energy(result.first, result.data)
    least = criteria.min_improvement_sigma**2
    remaining = result.last.energy - data.samples
    if whole <= 0.0 or remaining < max(least * data.samples, ACCEPTANCE.unknown_share * whole):
        return result
    curve = next(iter(fit_curves(result.last, data)), None)
    if curve is None or curve.energy < ACCEPTANCE.unknown_share * whole or not _is_significant(curve, result, criteria):
        return result
    curve = fit_acting(curve, result.last, data)
    share = _share(curve, result.first, data)
    if share < ACCEPTANCE.unknown_share:
        return result
    if data.validation and curve.validation_energy < least * data.validation_samples:
        return result
    if _p_value(curve, result.last) > criteria.significance:
        return result
    return replace(result, curve=curve, curve_share=share)


def _p_value(curve: FittedCurve, model: RefittedModel) -> float:
    """p-value of a curve being noise of any colour."""
    held_out = gain_of_samples(curve.decrease) if curve.decrease else None
    return together(curve_p_value(model, curve.basis.forces), held_out)


def without_imitations(result: SearchResult, better: FittedCurve, before: EvaluationData) -> SearchResult:
    """The result with its causes rejected for a curve that explains the misfit better.

    The curve is that by the noise behind the first model, for behind models that only imitate, the noise is uncertain.
    before : the data with that noise.
    """
    curve, data = fit_acting_along(better.variable, result.first, before), before
    if _share(curve, result.first, before) < ACCEPTANCE.unknown_share:
        curve, data = better, result.data
    share = _share(curve, result.first, data)
    why = f"only imitates: a free curve along {curve.curve.along} explains {100 * share:.0f} % of the misfit"
    found = result.without_causes([why] * len(result.causes))
    return replace(found, data=data, curve=curve, curve_share=share)


def without_parts(result: SearchResult) -> SearchResult:
    """The result with its causes rejected where what makes no sense explains clearly more than all of them: they are a
    part of what that imitates."""
    like = next((one for one in result.rejected if one.imitates), None)
    if like is None or not result.causes:
        return result
    first, data = result.first, result.data
    explained = share_removed(first, first, result.last, data, plain=is_plain(first, data))
    if explained >= ACCEPTANCE.imitation_share * like.explained:
        return result
    why = f"only a part: {like.effect}, which makes no sense here, explains {100 * like.explained:.0f} % of the misfit"
    return result.without_causes([why] * len(result.causes))


def _share(curve: FittedCurve, first: RefittedModel, data: EvaluationData) -> float:
    """Share of the first model's misfit that a curve explains."""
    return float(np.clip(curve.energy / max(misfit_energy(first, data), 1e-9), 0.0, 1.0))


def _is_significant(curve: FittedCurve, result: SearchResult, criteria: Criteria) -> bool:
    samples, tries = result.data.samples, len(result.rounds[-1].scores)
    p = significance(curve.energy, len(curve.values), result.last.energy, samples, tries)
    return p < criteria.significance and curve.energy > criteria.min_improvement_sigma**2 * samples
