"""What the search for missing effects finds: causes, what was turned down, and the curve no effect explains."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.noise.whitening import whitened_energy
from robotid.diagnosis.nonparametric.curve_fit import Shape
from robotid.diagnosis.refit.refitted_model import EvaluationData, RefittedModel
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.search.record_changes import Change

Log = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A cause that was accepted. explained : share of the first model's misfit that it removes from the fitted records;
    gain : of held-out fit in % points; twins : effects, itself first; before, after : the trials; rival : of the first
    twin."""

    effect: str
    explained: float
    gain: float
    p_value: float
    twins: tuple[str, ...]
    before: RefittedModel
    after: RefittedModel
    rival: RefittedModel | None = None


@dataclass(frozen=True, slots=True)
class RejectedCause:
    """An effect that was turned down."""

    effect: str
    explained: float
    gain: float
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """What a search found. first, last : the model before and with all causes; bench : the last, and what noise is
    there. shape : the curve that explains most of what the causes leave, None where that is nothing; share : of the
    first model's misfit. changes : what differs on records held out."""

    bench: EvaluationData
    first: RefittedModel
    last: RefittedModel
    causes: tuple[Found, ...]
    turned: tuple[RejectedCause, ...]
    rounds: tuple[Round, ...]
    shape: Shape | None = None
    share: float = 0.0
    changes: tuple[Change, ...] = ()


def misfit_energy(trial: RefittedModel, bench: EvaluationData) -> float:
    """Energy of a model's residuals beyond the noise, as a bench sees them."""
    return whitened_energy(trial.residuals, bench.whiten) - bench.samples


def share_removed(first: RefittedModel, now: RefittedModel, after: RefittedModel, bench: EvaluationData) -> float:
    """Share of the first model's misfit energy, as this bench sees it, that a step removes."""
    removed = misfit_energy(now, bench) - misfit_energy(after, bench)
    return float(np.clip(removed / max(misfit_energy(first, bench), 1e-9), 0.0, 1.0))
