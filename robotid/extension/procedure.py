"""Extending a model by its causes: the whole fitted anew, and measured on every record before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.results import Rejected
from robotid.estimate.result import FitResult
from robotid.extension.results import Extension, Score
from robotid.extension.task import ExtensionTask, ScoredFit, fits_with, gain, others_than, tries_with
from robotid.model.units import unit_of
from robotid.signals.record import Record

OTHERS_DO = "the other causes do as well without it on the held-out records"
DOES_NOT_CARRY_OVER = "does not carry over: the held-out records are simulated no better with it"


def extend(task: ExtensionTask, effects: Sequence[str]) -> Extension:
    """Fit a model with further effects on the records of its fit, and score it on all.

    Effects without which it converges and does at least as well on the validation records are dropped. Raises
    NumericsError where the extended model does not converge.
    """
    before, kept, dropped = task.before, list(effects), list[Rejected]()
    base, whole = fits_with(task, [(), kept]) if kept else 2 * fits_with(task, [()])
    task = task.on_simulated([base, whole])
    tried = [effect for effect in effects if task.validation]
    while tried:
        leaner = next_leaner(task, whole, base, kept, tried)
        if leaner is None:
            break
        effect = leaner.without
        why = OTHERS_DO if leaner.kept else DOES_NOT_CARRY_OVER
        dropped.append(Rejected(effect, 0.0, gain(task.validation_fit(whole.scores), leaner.level), why))
        tried = [one for one in tried[tried.index(effect) + 1 :] if one in leaner.kept]
        kept, whole = leaner.kept, leaner.scored
    if dropped and kept:
        found = {p.name: p.value for p in whole.fit.parameters}
        (whole,) = fits_with(replace(task, starts=(found,)), [kept])  # as found, now with standard deviations
    after, scores, scores_before = whole.fit, whole.scores, base.scores
    noise = {name: score.rmse for name, score in scores.items()}
    return Extension(
        model=before.name,
        output=before.output,
        unit=unit_of(before.output, linear=before.structure.linear),
        model_before=before.structure.effects,
        model_after=after.structure.effects,
        added=tuple(kept),
        before=scores_before,
        after=scores,
        bic_before=information_criterion(before, scores_before, noise, task.records),
        bic_after=information_criterion(after, scores, noise, task.records),
        fit=after,
        dropped=tuple(dropped),
        late=task.clock.late,
        late_within=task.clock.most,
        events=task.events,
        tones=task.tones,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Leaner:
    """A model without an effect and what rests on it. level : its mean fit on the validation records [%]."""

    without: str
    kept: list[str]
    scored: ScoredFit
    level: float


def next_leaner(
    task: ExtensionTask, whole: ScoredFit, base: ScoredFit, kept: Sequence[str], tried: Sequence[str]
) -> Leaner | None:
    """The model without the first of the tried effects that does at least as well on the validation records; None where
    each is worth keeping."""
    choices = [others_than(kept, effect) for effect in tried]
    level = task.validation_fit(whole.scores)
    with tries_with(task, choices) as found:
        for k, effect in enumerate(tried):
            task.log(f"trying without {effect}")
            lean = found[k] if choices[k] else base
            if lean is not None and level <= task.validation_fit(lean.scores):
                return Leaner(effect, choices[k], lean, task.validation_fit(lean.scores))
    return None


def information_criterion(
    fit: FitResult, scores: Mapping[str, Score], noise: Mapping[str, float], records: Sequence[Record]
) -> float:
    """Bayesian information criterion on the records of the fit (Schwarz 1978).

    noise : RMS error of the noise by record, the same for every model that is compared: a model that takes its own
    misfit for noise is compared on another scale.
    """
    used = [r for r in records if r.name in fit.records and r.name in scores and r.name in noise]
    samples = sum(map(len, used))
    variances = {r.name: max(noise[r.name] ** 2, np.finfo(np.float64).tiny) for r in used}
    likelihood = sum(len(r) * (np.log(variances[r.name]) + scores[r.name].rmse ** 2 / variances[r.name]) for r in used)
    return float(likelihood + sum(not p.fixed for p in fit.parameters) * np.log(samples))
