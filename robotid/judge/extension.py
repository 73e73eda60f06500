"""Extending a model by its causes: the whole fitted anew, and measured on every record before and after."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.residual import OutputError
from robotid.estimate.result import FitResult
from robotid.judge.diagnosis import Extension, Rejected, Score
from robotid.judge.simulated import Model, fitted_model, simulate_record
from robotid.judge.trial import carried
from robotid.judge.verdict import root_mean_square, trace
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.structure import rests_on
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record
from robotid.simulate.assemble import assemble

OTHERS_DO = "the other causes do as well without it on the held-out records"
DOES_NOT_CARRY_OVER = "does not carry over: the held-out records are simulated no better with it"

Starts = Mapping[str, float]
"""Values of parameters to start from, by dotted name; the others start as they were."""


def extend(
    before: FitResult,
    effects: Sequence[str],
    starts: Sequence[Starts],
    records: Sequence[Record],
    options: FitOptions,
    horizon: float | None,
    say: Callable[[str], None],
) -> Extension:
    """Fit a model with further effects on the records of its fit, and score it on all.

    starts : to choose the best of. Effects without which it does at least as well on the records held out are dropped.
    Raises NumericsError where the extended model does not converge.
    """
    old = fitted_model(before, estimate_states=options.estimate_states)
    say("measuring the model as it is")
    earlier = _scores(old, records, horizon)
    kept, dropped = list(effects), list[Rejected]()
    after, scores = _fit(before, old, kept, starts, records, options, horizon, say)
    for effect in effects:
        if all(s.used for s in scores.values()):
            break
        if effect not in kept:
            continue
        others = _others(kept, effect)
        say(f"trying without {effect}")
        leaner, lean = (
            _fit(before, old, others, starts, records, options, horizon, say) if others else (before, earlier)
        )
        lost = _held(scores) - _held(lean)
        if lost <= 0.0:
            why = OTHERS_DO if others else DOES_NOT_CARRY_OVER
            dropped.append(Rejected(effect, 0.0, lost, why))
            kept, after, scores = others, leaner, lean
    return Extension(
        model=before.name,
        output=before.output,
        unit="rad/s" if before.output == "speed" else "rad",
        model_before=before.structure.effects,
        model_after=after.structure.effects,
        added=tuple(kept),
        before=earlier,
        after=scores,
        bic_before=_criterion(before, earlier, records),
        bic_after=_criterion(after, scores, records),
        fit=after,
        dropped=tuple(dropped),
    )


def gains(
    before: FitResult,
    effects: Sequence[str],
    starts: Sequence[Starts],
    records: Sequence[Record],
    options: FitOptions,
    horizon: float | None,
    say: Callable[[str], None],
) -> list[float]:
    """What each effect gains on the records held out once the earlier ones are there [% points of fit]; what gains
    nothing so, beside all others. nan without such records. Raises NumericsError as `extend` does."""
    old = fitted_model(before, estimate_states=options.estimate_states)
    if all(r.name in before.records for r in records):
        return [float("nan")] * len(effects)

    def held(some: Sequence[str]) -> float:
        return _held(_fit(before, old, some, starts, records, options, horizon, say)[1])

    reached = [_held(_scores(old, records, horizon)), *(held(effects[: k + 1]) for k in range(len(effects)))]
    found = [after - earlier for earlier, after in pairwise(reached)]
    alone = [k for k, gain in enumerate(found[:-1]) if gain <= 0.0]
    for k in alone:
        found[k] = reached[-1] - held(_others(effects, effects[k]))
    return found


def _others(effects: Sequence[str], effect: str) -> list[str]:
    """The effects that can be without one."""
    return [e for e in effects if e != effect and not rests_on(e, effect)]


def _fit(
    before: FitResult,
    old: Model,
    effects: Sequence[str],
    starts: Sequence[Starts],
    records: Sequence[Record],
    options: FitOptions,
    horizon: float | None,
    say: Callable[[str], None],
) -> tuple[FitResult, dict[str, Score]]:
    structure = before.structure
    for effect in effects:
        structure = structure.extended(effect)
    joint = assemble(structure, angle=before.output == "position")
    used = [r for r in records if r.name in before.records]
    say(f"fitting with {', '.join(effects)}" if effects else "fitting")
    start = _best([carried(old.parameters, structure, values) for values in starts], joint, used, old)
    fit = fit_model(before.name, joint, start, used, options)
    return fit, _scores(fitted_model(fit, estimate_states=options.estimate_states), records, horizon)


def _best(starts: Sequence[Parameters], joint: Joint, records: Sequence[Record], old: Model) -> Parameters:
    """The start from which the records are simulated best."""

    def cost(start: Parameters) -> float:
        weights = np.ones(len(records))
        problem = OutputError(joint, start, tuple(records), old.output, weights, old.estimate_states)
        try:
            return problem.evaluate(problem.start()).cost
        except NumericsError:
            return np.inf

    return starts[0] if len(starts) == 1 else min(starts, key=cost)


def _scores(model: Model, records: Sequence[Record], horizon: float | None) -> dict[str, Score]:
    """A model on every record on which it can be simulated."""
    found = {}
    for record in records:
        try:
            run = simulate_record(model, record, horizon)
        except NumericsError:
            continue
        measured, simulated = run.measured(model.output), run.signal(model.output)
        found[record.name] = Score(
            record.role,
            record.name in model.records,
            fit_percent(measured, simulated),
            root_mean_square(measured - simulated),
            trace(run, model),
        )
    return found


def _held(scores: Mapping[str, Score]) -> float:
    """Mean fit on the records held out [%]."""
    return float(np.mean([s.fit_percent for s in scores.values() if not s.used]))


def _criterion(fit: FitResult, scores: Mapping[str, Score], records: Sequence[Record]) -> float:
    """Bayesian information criterion on the records of the fit, each with its own noise (Schwarz 1978)."""
    used = [r for r in records if r.name in fit.records and r.name in scores]
    samples = sum(map(len, used))
    likelihood = sum(len(r) * np.log(scores[r.name].rmse ** 2) for r in used)
    return float(likelihood + sum(not p.fixed for p in fit.parameters) * np.log(samples))
