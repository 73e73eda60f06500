"""What each cause of a diagnosis gains, by fits as the pipeline makes them.

The search for causes weighs the residual by its noise; a fit does not. The gains that are reported are those that an
extension will show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from robotid.diagnosis.results import Diagnosis
from robotid.estimate.result import FitResult
from robotid.extension.task import ExtensionTask, effects_to_add, gain, others_than
from robotid.model.structure import belongs


def gains(task: ExtensionTask, effects: Sequence[str]) -> tuple[list[float], FitResult | None]:
    """What each effect gains on the validation records once the earlier ones are there [% points of fit]; for what
    gains nothing so, the gain beside all others; and the fit with all effects.

    nan and None without validation records or without effects, nan where a model cannot be simulated. Raises
    NumericsError where a fit with some first effects does not converge.
    """
    if not effects or not task.validation:
        return [float("nan")] * len(effects), None

    def reached(fit: FitResult | None) -> float:
        return task.validation_fit({} if fit is None else task.scores(fit))

    fits = [task.before, *(task.fit_with(effects[: k + 1]) for k in range(len(effects)))]
    levels = [reached(fit) for fit in fits]
    found = [gain(after, before) for before, after in pairwise(levels)]
    for k, value in enumerate(found[:-1]):
        if value <= 0.0:
            found[k] = gain(levels[-1], reached(task.try_fit_with(others_than(effects, effects[k]))))
    return found, fits[-1]


def with_gains(diagnosis: Diagnosis, task: ExtensionTask) -> Diagnosis:
    """The diagnosis with the gains and parameters that its causes have in fits as the pipeline makes them, those that
    an extension will find."""
    effects = effects_to_add(diagnosis, task.before)
    found, last = gains(task, effects)
    if last is None:
        return diagnosis
    gained = dict(zip(effects, found, strict=True))
    causes = tuple(
        replace(
            cause,
            heldout_gain=gained[cause.effect],
            parameters=tuple(p for p in last.parameters if belongs(p.name, cause.effect)),
        )
        if cause.effect in gained
        else cause
        for cause in diagnosis.causes
    )
    return replace(diagnosis, causes=causes, refitted={p.name: p.value for p in last.parameters})
