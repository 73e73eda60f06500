"""The events of a stage while it works, for whoever shows them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Begun:
    """A stage has begun; without a name, one has ended and none is at work."""

    stage: str


@dataclass(frozen=True, slots=True)
class Progress:
    """What a stage is about to do, and how many of how many units of work are done; total is 0 where nobody knows."""

    label: str
    done: int = 0
    total: int = 0


@dataclass(frozen=True, slots=True)
class Iteration:
    """One line of the iteration log."""

    number: int
    cost: float
    decrease: float


@dataclass(frozen=True, slots=True)
class Step:
    """An iteration of the fit of a model, one of several."""

    model: str
    models: tuple[str, ...]
    iteration: Iteration


Log = Callable[[Begun | Progress | Step], None]
"""What a stage with `logs` takes. Code below the stages takes a callable of a text, and
its stage hands it on: lambda text: log(Progress(text))."""
