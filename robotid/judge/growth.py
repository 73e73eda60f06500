"""What the search for missing effects finds: causes, what was turned down, and the curve no effect explains."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robotid.judge.changes import Change
from robotid.judge.ranking import Round
from robotid.judge.trial import Bench, Trial
from robotid.judge.unknown import Shape
from robotid.judge.whitening import whitened_energy

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
    before: Trial
    after: Trial
    rival: Trial | None = None


@dataclass(frozen=True, slots=True)
class Turned:
    """An effect that was turned down."""

    effect: str
    explained: float
    gain: float
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """What a search found. first, last : the model before and with all causes; bench : the last, and what noise is
    there. shape : the curve that explains most of what the causes leave, None where that is nothing; share : of the
    first model's misfit. changes : what differs on records held out."""

    bench: Bench
    first: Trial
    last: Trial
    causes: tuple[Found, ...]
    turned: tuple[Turned, ...]
    rounds: tuple[Round, ...]
    shape: Shape | None = None
    share: float = 0.0
    changes: tuple[Change, ...] = ()


def misfit_energy(trial: Trial, bench: Bench) -> float:
    """Energy of a model's residuals beyond the noise, as a bench sees them."""
    return whitened_energy(trial.residuals, bench.whiten) - bench.samples


def share_removed(first: Trial, now: Trial, after: Trial, bench: Bench) -> float:
    """Share of the first model's misfit energy, as this bench sees it, that a step removes."""
    removed = misfit_energy(now, bench) - misfit_energy(after, bench)
    return float(np.clip(removed / max(misfit_energy(first, bench), 1e-9), 0.0, 1.0))
