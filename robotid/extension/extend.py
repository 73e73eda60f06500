"""Extending a model by its causes: the whole fitted anew, and measured on every record before and after."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.refit.refitted_model import carried
from robotid.diagnosis.results import Rejected
from robotid.diagnosis.verdict import root_mean_square, trace
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, fitted_model, simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.result import FitResult
from robotid.extension.results import Extension, Score
from robotid.model.structure import Structure, rests_on
from robotid.model.units import unit_of
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record

OTHERS_DO = "the other causes do as well without it on the held-out records"
DOES_NOT_CARRY_OVER = "does not carry over: the held-out records are simulated no better with it"

Starts = Mapping[str, float]
"""Values of parameters to start from, by dotted name; the others start as they were."""


@dataclass(frozen=True, slots=True)
class Refit:
    """A model to be extended, by fits as the pipeline makes them. before : its fit; starts : to choose the best of;
    records : all of them; horizon [s] : of the simulations; say : told what is being done."""

    before: FitResult
    starts: Sequence[Starts]
    records: Sequence[Record]
    options: FitOptions
    horizon: float | None
    say: Callable[[str], None]

    @property
    def held(self) -> list[str]:
        """The records that the fit has not seen."""
        return [r.name for r in self.records if r.name not in self.before.records]

    def scores(self, fit: FitResult) -> dict[str, Score]:
        """A fit on every record on which it can be simulated."""
        return _scores(fitted_model(fit, estimate_states=self.options.estimate_states), self.records, self.horizon)

    def fit(self, effects: Sequence[str]) -> FitResult:
        """The model with further effects, fitted on the records of its fit. Raises NumericsError."""
        old = fitted_model(self.before, estimate_states=self.options.estimate_states)
        structure = reduce(Structure.extended, effects, self.before.structure)
        joint = assemble(structure, angle=self.before.output == "position")
        used = [r for r in self.records if r.name in self.before.records]
        self.say(f"fitting with {', '.join(effects)}" if effects else "fitting")
        first, *others = (carried(old.parameters, structure, values) for values in self.starts)
        return fit_model(self.before.name, joint, first, used, self.options, others=others)

    def try_fit(self, effects: Sequence[str]) -> FitResult | None:
        """The same, or the model as it was without further effects; None where it does not converge."""
        try:
            return self.fit(effects) if effects else self.before
        except NumericsError:
            return None


def extend(refit: Refit, effects: Sequence[str]) -> Extension:
    """Fit a model with further effects on the records of its fit, and score it on all.

    Effects without which it converges and does at least as well on the records held out are dropped. Raises
    NumericsError where the extended model does not converge.
    """
    before = refit.before
    refit.say("measuring the model as it is")
    earlier = refit.scores(before)
    kept, dropped = list(effects), list[Rejected]()
    after = refit.fit(kept)
    scores = refit.scores(after)
    for effect in effects:
        if effect not in kept or not refit.held:
            continue
        others = _others(kept, effect)
        refit.say(f"trying without {effect}")
        leaner = refit.try_fit(others)
        if leaner is None:
            continue
        lean = refit.scores(leaner) if others else earlier
        whole, part = _mean_fit(scores, refit.held), _mean_fit(lean, refit.held)
        if whole <= part:
            why = OTHERS_DO if others else DOES_NOT_CARRY_OVER
            dropped.append(Rejected(effect, 0.0, _gain(whole, part), why))
            kept, after, scores = others, leaner, lean
    return Extension(
        model=before.name,
        output=before.output,
        unit=unit_of(before.output, linear=before.structure.linear),
        model_before=before.structure.effects,
        model_after=after.structure.effects,
        added=tuple(kept),
        before=earlier,
        after=scores,
        bic_before=_criterion(before, earlier, refit.records),
        bic_after=_criterion(after, scores, refit.records),
        fit=after,
        dropped=tuple(dropped),
    )


def gains(refit: Refit, effects: Sequence[str]) -> tuple[list[float], FitResult | None]:
    """What each effect gains on the records held out once the earlier ones are there [% points of fit]; what gains
    nothing so, beside all others; and the fit with all. nan and none without such records or without effects, nan
    where one of them cannot be simulated. Raises NumericsError as `extend` does."""
    if not effects or not refit.held:
        return [float("nan")] * len(effects), None

    def reaches(fit: FitResult | None) -> float:
        return _mean_fit({} if fit is None else refit.scores(fit), refit.held)

    fits = [refit.before, *(refit.fit(effects[: k + 1]) for k in range(len(effects)))]
    reached = [reaches(fit) for fit in fits]
    found = [_gain(after, earlier) for earlier, after in pairwise(reached)]
    alone = [k for k, gain in enumerate(found[:-1]) if gain <= 0.0]
    for k in alone:
        found[k] = _gain(reached[-1], reaches(refit.try_fit(_others(effects, effects[k]))))
    return found, fits[-1]


def _gain(after: float, before: float) -> float:
    return after - before if np.isfinite([after, before]).all() else float("nan")


def _others(effects: Sequence[str], effect: str) -> list[str]:
    """The effects that can be without one."""
    return [e for e in effects if e != effect and not rests_on(e, effect)]


def _scores(model: FittedModel, records: Sequence[Record], horizon: float | None) -> dict[str, Score]:
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


def _mean_fit(scores: Mapping[str, Score], names: Sequence[str]) -> float:
    """Mean fit on records [%], without bound below where one of them cannot be simulated."""
    return float(np.mean([scores[name].fit_percent if name in scores else -np.inf for name in names]))


def _criterion(fit: FitResult, scores: Mapping[str, Score], records: Sequence[Record]) -> float:
    """Bayesian information criterion on the records of the fit, each with its own noise (Schwarz 1978)."""
    used = [r for r in records if r.name in fit.records and r.name in scores]
    samples = sum(map(len, used))
    likelihood = sum(len(r) * np.log(scores[r.name].rmse ** 2) for r in used)
    return float(likelihood + sum(not p.fixed for p in fit.parameters) * np.log(samples))
