"""Causes that the search has accepted, judged once more by a fit as the pipeline makes it.

The search weighs a residual by its noise, and sees what is far below the rest of it. A cause that gains nothing in a
fit is not worth a name, and neither is one whose size such a fit cannot tell from none: at three deviations, and at the
level of significance of a whole round, for it was found as the best of all effects. Nor is one that a record which was
held out shows the other way round: it imitates something that is not in the catalogue, and what differs beside it only
makes up for that.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.remarks import without_name
from robotid.diagnosis.results import Cause, DetectionLimit, Diagnosis, Rejected, Verdict
from robotid.diagnosis.search.physical_sense import declarations, least_deviations
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.settings import VERDICT
from robotid.diagnosis.verdict import is_partial, without_cause
from robotid.estimate.result import Estimate, FitResult
from robotid.estimate.uncertainty import deviations_with_shape
from robotid.model.structure import changed, is_change, rests_on

NOT_CONFIRMED = "a fit does not confirm it: the held-out records gain nothing by it"
UNCERTAIN = "a fit does not confirm it: {} = {:.2g}, known to {:.2g}"
ANOTHER_SIZE = "is not the same in all records: {} of {} differs by {:.0f} % of its size"
RESTS = "only makes up for {}, which is no cause"
BESIDE = "carries over only beside {}, which is no cause"


def is_idle(cause: Cause) -> bool:
    """Whether a fit with a cause gains nothing on records that it was not fitted to, where there are any."""
    return cause.heldout_gain < VERDICT.least_gain


def _sizes(cause: Cause) -> list[tuple[Estimate, float]]:
    """The amplitudes of a cause, and how far each is from where it vanishes."""
    nulls = {name: p.null for name, p in declarations(cause.effect) if p.null is not None}
    return [(one, one.value - nulls[one.name]) for one in cause.parameters if one.name in nulls]


@dataclass(frozen=True, slots=True)
class _Certainty:
    """The amplitudes of a cause, with how far each is from where it vanishes; how many deviations they are from there
    in a fit, beside its shape, and in the shape that was found if that is more; and how many parameters it has."""

    sizes: list[tuple[Estimate, float]]
    known: float
    certain: float
    parameters: int

    def share(self, level: float) -> float:
        """Of the size that a fit would distinguish from none, at a level among all shapes and known better than to
        itself."""
        return min(self.known / ACCEPTANCE.known_sigma, self.certain / least_deviations(self.parameters, level))


def _certainty(cause: Cause, fit: FitResult | None) -> _Certainty | None:
    """None where a cause has no amplitude, or a fit does not tell how well it knows it."""
    sizes = _sizes(cause)
    names, apart = [one.name for one, _ in sizes], np.array([size for _, size in sizes])
    if fit is None:
        robust = covariance = np.diag([one.std_robust**2 for one, _ in sizes])
        at, shape = list(range(len(sizes))), list[int]()
    else:
        robust, covariance, of_all = fit.covariance_robust, fit.covariance, [one.name for one in fit.parameters]
        at = [of_all.index(name) for name in names]
        shape = [of_all.index(one.name) for one in cause.parameters if one.name not in names]
    if not sizes or not np.isfinite(robust[np.ix_(at, at)]).all():
        return None
    known, certain = deviations_with_shape(apart, covariance, robust, at, shape)
    return _Certainty(sizes, known, certain, len(sizes) + len(shape))


def uncertain(cause: Cause, fit: FitResult | None = None, level: float = 1.0) -> str | None:
    """Why a cause is none whose amplitudes together are less than three standard deviations in a fit, be it in the
    shape that was found, or not significant at a level among all shapes, or known less well than to themselves, in
    words; None where they are more. Those are robust ones, for what a model leaves is seldom white. fit : that tells
    how the amplitudes depend on each other and on the shape, absent: they do not."""
    found = _certainty(cause, fit)
    if found is None or found.share(level) >= 1.0:
        return None
    first, _ = found.sizes[0]
    return UNCERTAIN.format(first.name.rpartition(".")[2], first.value, first.std_robust)


def another_size(cause: Cause, diagnosis: Diagnosis) -> str | None:
    """Why a cause is none that a record which was held out shows the other way round, or more than twice as large, in
    words; None where no record does."""
    sizes = _sizes(cause)
    names, size = {one.name for one, _ in sizes}, float(np.linalg.norm([value for _, value in sizes]))
    for other in diagnosis.causes:
        if is_change(other.effect) and other.explained_of:
            record, parameter = changed(other.effect)
            apart = abs(other.parameters[0].value)
            if parameter in names and apart > size:
                return ANOTHER_SIZE.format(parameter.rpartition(".")[2], record, 100.0 * apart / max(size, 1e-300))
    return None


def unconfirmed(diagnosis: Diagnosis, fit: FitResult | None = None, criteria: Criteria | None = None) -> dict[str, str]:
    """The causes that are none after all, by name, and why: those of quite another size on records that were held out,
    all that differs beside these, what gains nothing, and what a fit tells no size of. fit : with all that can be
    fitted, as of `uncertain`; criteria : of the search."""
    causes = _effects(diagnosis)
    found = {one.effect: why for one in causes if (why := another_size(one, diagnosis)) is not None}
    if found:
        beside = RESTS.format(", ".join(found))
        found |= {one.effect: beside for one in diagnosis.causes if one.explained_of}
    idle = [one for one in diagnosis.causes if is_idle(one) and not one.explained_of]
    return unsized(diagnosis, fit, criteria) | {one.effect: NOT_CONFIRMED for one in idle} | found


def unsized(diagnosis: Diagnosis, fit: FitResult | None = None, criteria: Criteria | None = None) -> dict[str, str]:
    """The causes that a fit tells no size of, by name, and why: arguments as of `unconfirmed`. Of several each may be
    so only beside the others, where they act alike."""
    causes = (one for one in _effects(diagnosis) if not one.explained_of)
    sought = {one.effect: uncertain(one, fit, _level(one, diagnosis, criteria)) for one in causes}
    return {effect: why for effect, why in sought.items() if why is not None}


def with_limits(
    diagnosis: Diagnosis, effects: Collection[str], fit: FitResult, criteria: Criteria | None = None
) -> Diagnosis:
    """The diagnosis with the detection limits of causes that a fit tells no size of, which are about to go: the size
    that it would tell from none, infinite where none may be so large. effects : their names; the other arguments are
    those of `unconfirmed`."""
    limits = {one.effect: one for one in diagnosis.limits}
    for cause in (one for one in _effects(diagnosis) if one.effect in effects):
        found, level = _certainty(cause, fit), _level(cause, diagnosis, criteria)
        if found is not None:
            size = float(np.linalg.norm([apart for _, apart in found.sizes])) / max(found.share(level), 1e-300)
            first, apart = found.sizes[0]
            limit = DetectionLimit(cause.effect, first.name.rpartition(".")[2], size, first.unit)
            limits[cause.effect] = limit.within(first.value - apart, (first.lower, first.upper))
    return replace(diagnosis, limits=tuple(limits[name] for name in sorted(limits)))


def _effects(diagnosis: Diagnosis) -> list[Cause]:
    """The causes that are no changes of a record."""
    return [cause for cause in diagnosis.causes if not is_change(cause.effect)]


def _level(cause: Cause, diagnosis: Diagnosis, criteria: Criteria | None) -> float:
    """At which a fit must tell the size of a cause from none: that of significance for one of all effects that were
    sought. Where the gain on records held out, of which the fit knows nothing, tells of the cause, too, it is both
    p-values together that must reach it (Fisher 1932)."""
    level = (criteria or Criteria()).significance / max(1, len(_effects(diagnosis)) + len(diagnosis.limits))
    least = float(np.exp(-0.5 * chi2.isf(level, 4)))  # of a product of two p-values
    return max(level, min(1.0, least / max(cause.gain_p_value, least)))


def without_causes(diagnosis: Diagnosis, why: Mapping[str, str]) -> Diagnosis:
    """The diagnosis with causes rejected, and what rests on them. why : each is none, by name."""
    none = {one.effect: why[one.effect] for one in diagnosis.causes if one.effect in why}
    for one in diagnosis.causes:
        of = next((effect for effect in why if rests_on(one.effect, effect) or one.beside == effect), None)
        if of is not None:
            none.setdefault(one.effect, (BESIDE if one.beside == of else RESTS).format(of))
    idle = [one for one in diagnosis.causes if one.effect in none]
    kept = tuple(one for one in diagnosis.causes if one.effect not in none)
    left = tuple(Rejected(one.effect, one.explained, one.heldout_gain, none[one.effect]) for one in idle)
    given = sum(one.explained for one in idle if not one.explained_of)
    share = min(1.0, diagnosis.remaining_share + given)
    energy = min(diagnosis.misfit**2, diagnosis.remaining**2 + given * diagnosis.misfit**2)
    remaining = diagnosis.misfit if not kept else float(np.sqrt(energy))
    whole = max(1.0 - diagnosis.remaining_share, 1e-300)
    records = {
        name: replace(one, explained_after=one.explained_after * (1.0 - share) / whole)
        for name, one in diagnosis.records.items()
    }
    verdict = _verdict(diagnosis, kept, share, remaining)
    lost = verdict == "unknown" and diagnosis.torque_errors > 0.0  # what the causes left passed for them, no more
    return replace(
        diagnosis,
        verdict=verdict,
        torque_errors=0.0 if lost else diagnosis.torque_errors,
        remarks=without_name(diagnosis.remarks) if lost else diagnosis.remarks,
        causes=kept,
        rejected=(*left, *diagnosis.rejected),
        remaining=remaining,
        remaining_share=share,
        records=records,
    )


def _verdict(diagnosis: Diagnosis, kept: tuple[Cause, ...], share: float, remaining: float) -> Verdict:
    """In one word, with fewer causes. What is more than the errors of the torque for which the rest passed beside them
    is something, though no cause."""
    if diagnosis.verdict == "not explained":
        return "not explained"
    if kept:
        partial = is_partial(share, diagnosis.misfit, remaining, diagnosis.noise_floor)
        return "partly named" if partial else diagnosis.verdict
    beyond_errors = diagnosis.torque_errors > 0.0 and diagnosis.misfit > diagnosis.noise_floor
    something = diagnosis.shape is not None or beyond_errors
    return without_cause(diagnosis.misfit, diagnosis.noise_floor, shape=something, events=bool(diagnosis.events))
