"""What each cause of a diagnosis gains, by fits as the pipeline makes them.

The search for causes weighs the residual by its noise; a fit does not. The gains that are reported are those that an
extension will show.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

from robotid.diagnosis.confirmation import unconfirmed, unsized, with_limits, without_causes
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.procedure import DiagnosisOptions, examine
from robotid.diagnosis.results import Diagnosis
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel
from robotid.estimate.grey_box import FitOptions
from robotid.estimate.result import FitResult
from robotid.extension.task import (
    ExtensionTask,
    ScoredFit,
    effects_to_add,
    extension_task,
    fits_ahead,
    fits_made,
    fits_with,
    gain,
    others_than,
    tried_with,
)
from robotid.interrupt import OutOfTime, deadline
from robotid.model.structure import belongs
from robotid.signals.record import Record

AT_RECORDED_ANGLE = (
    "torques that depend on the motor's angle act at the recorded angle (robot.recorded_angle), for that of an"
    " open-loop simulation drifts with every error of the torque"
)
GAINS_OF_SEARCH = "the gains and parameters of the causes are those of the search: {}"
GAINS_BESIDE_OTHERS = (
    "the gains and parameters of the causes are those of a fit with others, which it did not confirm: {}"
)
NO_TIME, NO_END = "no time was left to fit them", "no fit with them comes to an end"


Known = dict[tuple[str, ...], ScoredFit]
"""Fits of a task, by the effects that were added."""


def gains(
    task: ExtensionTask, effects: Sequence[str], known: Known | None = None, begun: Iterable[ScoredFit] | None = None
) -> tuple[list[float], FitResult | None]:
    """What each effect gains on the validation records once the earlier ones are there [% points of fit]; for what
    gains nothing so, the gain beside all others; and the fit with all effects.

    known : fits of this task, which are not made again; those that are made join them. begun : of `fits_ahead`, of all
    `choices_of` this task. nan without validation records that any of these models can be simulated on, or where one of
    them cannot, and no fit without effects. Raises NumericsError where a fit with some first effects does not converge.
    """
    if not effects:
        return [], None
    known, choices = {} if known is None else known, choices_of(task, effects)
    further = [one for one in choices[:-1] if one not in known] + choices[-1:]  # the last with standard deviations
    made = fits_with(task, further, everywhere=False) if begun is None else fits_made(task, further, begun)
    known |= zip(further, made, strict=True)
    fitted = [known[one] for one in choices]
    task = task.on_simulated(fitted)
    if not task.validation:
        return [float("nan")] * len(effects), fitted[-1].fit
    levels = [task.validation_fit(one.scores) for one in fitted]
    found = [gain(after, before) for before, after in pairwise(levels)]
    idle = [k for k, value in enumerate(found[:-1]) if value <= 0.0]
    for k, one in zip(idle, tried_with(task, [others_than(effects, effects[k]) for k in idle]), strict=True):
        found[k] = gain(levels[-1], task.validation_fit({} if one is None else one.scores))
    return found, fitted[-1].fit


def choices_of(task: ExtensionTask, effects: Sequence[str]) -> list[tuple[str, ...]]:
    """The effects of each fit that tells what further effects gain; where no record is held out, there is but one."""
    return [tuple(effects[:k]) for k in range(0 if task.validation else len(effects), len(effects) + 1)]


def diagnose_with_gains(
    model: FittedModel,
    fit: FitResult,
    records: Sequence[Record],
    fit_options: FitOptions,
    criteria: Criteria | None = None,
    options: DiagnosisOptions | None = None,
    log: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """The diagnosis of a model, with the gains of its causes as of `with_gains`; their fits are made while it is
    measured where the misfit sits. A budget of the options is one for both.

    model : what is diagnosed, of this fit; fit_options : of every fit, in pieces of the options' horizon. The rest and
    errors as of `diagnosis.diagnose`.
    """
    begin, options = time.monotonic(), options or DiagnosisOptions()
    examined = examine(model, records, criteria, options, log)
    task = extension_task(examined.outcome, fit, records, fit_options, horizon=options.horizon, log=log)
    effects = () if examined.outcome.beside_shape else effects_to_add(examined.outcome, fit)
    choices = choices_of(task, effects) if effects else []
    with deadline(None if options.budget is None else begin + options.budget), fits_ahead(task, choices) as begun:
        with deadline(None):
            diagnosis = examined.diagnosis()
            log("measuring the gains")
        return with_gains(diagnosis, task, criteria, begun)


def with_gains(
    diagnosis: Diagnosis,
    task: ExtensionTask,
    criteria: Criteria | None = None,
    begun: Iterable[ScoredFit] | None = None,
) -> Diagnosis:
    """The diagnosis with the gains and parameters that its causes have in fits as the pipeline makes them, those that
    an extension will find, and without those that such a fit does not confirm. Where a deadline is past, those of the
    search stay, and a remark tells so; another tells where causes act at the recorded angle. Those of causes beside a
    curve stay, too, for no fit of the pipeline has that. criteria : of the search; begun : as of `gains`, of the causes
    of the diagnosis."""
    judged = diagnosis if diagnosis.beside_shape else _confirmed(diagnosis, task, criteria or Criteria(), begun=begun)
    structure = task.structure_with(effects_to_add(judged, task.before))
    if structure.recorded_angle == task.before.structure.recorded_angle:
        return judged
    return replace(judged, remarks=(*judged.remarks, AT_RECORDED_ANGLE))


def _confirmed(
    diagnosis: Diagnosis,
    task: ExtensionTask,
    criteria: Criteria,
    known: Known | None = None,
    begun: Iterable[ScoredFit] | None = None,
) -> Diagnosis:
    """known, begun : as of `gains`; known of a diagnosis whose gains are those of a fit with further causes already."""
    effects = effects_to_add(diagnosis, task.before)
    as_it_is, known = (GAINS_OF_SEARCH, Known()) if known is None else (GAINS_BESIDE_OTHERS, known)
    try:
        found, last = gains(task, effects, known, begun)
    except OutOfTime:
        return replace(diagnosis, remarks=(*diagnosis.remarks, as_it_is.format(NO_TIME)))
    except NumericsError:
        return replace(diagnosis, remarks=(*diagnosis.remarks, as_it_is.format(NO_END)))
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
    judged = replace(diagnosis, causes=causes, refitted={p.name: p.value for p in last.parameters})
    none, alike = unconfirmed(judged, last, criteria), unsized(judged, last, criteria)
    doubted = [effect for effect in effects if effect in alike and none[effect] == alike[effect]]
    if len(doubted) > 1:  # each may have no size only beside the others
        task, known = task.without_sizes(doubted), {}
        try:
            first = _first_to_go(task, effects, doubted)
        except OutOfTime:
            return replace(diagnosis, remarks=(*diagnosis.remarks, as_it_is.format(NO_TIME)))
        none = {effect: why for effect, why in none.items() if effect not in doubted or effect in first}
    if not none:
        return replace(judged, extended=last)
    judged = with_limits(judged, alike.keys() & none.keys(), last, criteria)
    return _confirmed(without_causes(judged, none), task, criteria, known)


def _first_to_go(task: ExtensionTask, effects: Sequence[str], doubted: Sequence[str]) -> Sequence[str]:
    """Of effects that a fit tells no size of, the one without which a fit leaves least; all where none ends."""
    found = tried_with(task, [others_than(effects, effect) for effect in doubted])
    left = {effect: one.fit.misfit for effect, one in zip(doubted, found, strict=True) if one is not None}
    return [min(left, key=lambda effect: left[effect])] if left else doubted
