"""Extending a model by its causes: the whole fitted anew, and measured on every record before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robotid.diagnosis.results import Rejected
from robotid.estimate.result import FitResult
from robotid.extension.results import Extension, Score
from robotid.extension.task import ExtensionTask, gain, others_than
from robotid.model.units import unit_of
from robotid.signals.record import Record

OTHERS_DO = "the other causes do as well without it on the held-out records"
DOES_NOT_CARRY_OVER = "does not carry over: the held-out records are simulated no better with it"


def extend(task: ExtensionTask, effects: Sequence[str]) -> Extension:
    """Fit a model with further effects on the records of its fit, and score it on all.

    Effects without which it converges and does at least as well on the validation records are dropped. Raises
    NumericsError where the extended model does not converge.
    """
    before = task.before
    task.log("measuring the model as it is")
    scores_before = task.scores(before)
    kept, dropped = list(effects), list[Rejected]()
    after = task.fit_with(kept)
    scores = task.scores(after)
    for effect in effects:
        if effect not in kept or not task.validation:
            continue
        others = others_than(kept, effect)
        task.log(f"trying without {effect}")
        leaner = task.try_fit_with(others)
        if leaner is None:
            continue
        lean_scores = task.scores(leaner) if others else scores_before
        whole, lean = task.validation_fit(scores), task.validation_fit(lean_scores)
        if whole <= lean:
            why = OTHERS_DO if others else DOES_NOT_CARRY_OVER
            dropped.append(Rejected(effect, 0.0, gain(whole, lean), why))
            kept, after, scores = others, leaner, lean_scores
    return Extension(
        model=before.name,
        output=before.output,
        unit=unit_of(before.output, linear=before.structure.linear),
        model_before=before.structure.effects,
        model_after=after.structure.effects,
        added=tuple(kept),
        before=scores_before,
        after=scores,
        bic_before=information_criterion(before, scores_before, task.records),
        bic_after=information_criterion(after, scores, task.records),
        fit=after,
        dropped=tuple(dropped),
    )


def information_criterion(fit: FitResult, scores: Mapping[str, Score], records: Sequence[Record]) -> float:
    """Bayesian information criterion on the records of the fit, each with its own noise (Schwarz 1978)."""
    used = [r for r in records if r.name in fit.records and r.name in scores]
    samples = sum(map(len, used))
    likelihood = sum(len(r) * np.log(max(scores[r.name].rmse ** 2, np.finfo(np.float64).tiny)) for r in used)
    return float(likelihood + sum(not p.fixed for p in fit.parameters) * np.log(samples))
