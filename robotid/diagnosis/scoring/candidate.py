"""A candidate: an effect that a model could lack, at the value where it vanishes.

What the search needs of any candidate is its columns (what its parameters would add to the output), where a refit with
it starts, and, where a grid cannot hold its shapes, further points that are read off the misfit. Each kind of effect is
a class of this interface; what they share is computed for a whole group at once.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.signals.record import Quantity, Record
from robotid.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class ForceGradient:
    """What the whitened residual of a segment gains from a generalised force on each coordinate, (nv, n), constant over
    the interval after each sample."""

    segment: SimulatedSegment
    gradient: Array


@dataclass(frozen=True, slots=True)
class Candidate(ABC):
    """An effect at its null. name : as in verdicts; values : of its parameters, shapes at one point of their grids."""

    name: str
    values: tuple[float, ...]

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """Its parameters as they are declared."""

    @property
    def scored(self) -> tuple[int, ...]:
        """Indices of the parameters that make it appear."""
        return tuple(k for k, p in enumerate(self.parameters) if p.null is not None)

    def at(self, k: int, value: float) -> Self:
        """The candidate with another value of its parameter k."""
        return replace(self, values=(*self.values[:k], value, *self.values[k + 1 :]))

    def allows(self, amplitude: Sequence[float]) -> bool:
        """Whether no scored parameter would leave its bounds at the null for these amplitudes."""
        for k, a in zip(self.scored, amplitude, strict=True):
            low, high = self.parameters[k].bounds
            null = self.parameters[k].null
            if (a < 0 and low == null) or (a > 0 and high == null):
                return False
        return True

    def start(self, amplitude: Sequence[float]) -> Mapping[str, float]:
        """Where a refit starts: the values of its parameters by dotted name, the scored ones at these amplitudes."""
        symbols = [p.symbol for p in self.parameters]
        values = dict(zip(symbols, self.values, strict=True))
        values |= {symbols[k]: a for k, a in zip(self.scored, amplitude, strict=True)}
        return {f"{self.name}.{symbol}": value for symbol, value in values.items()}

    @property
    def whole(self) -> list[float]:
        """Amplitudes at which it is there as a whole, where it mostly is so or not at all; zero of one of any size."""
        scored = (self.parameters[k] for k in self.scored)
        return [p.guess if p.guess == p.bounds[1] else 0.0 for p in scored]

    @property
    def repeats(self) -> bool:
        """Whether it has as many shapes as a motion has turns, so that another start may lead elsewhere."""
        return self.counting is not None

    @property
    def counting(self) -> int | None:
        """The parameter that counts periods, where there is one."""
        return next((k for k, p in enumerate(self.parameters) if p.turns), None)

    @property
    def variant(self) -> tuple[float, ...]:
        """Which of several laws of one name it is: its shapes that no fit estimates, and the sides of barriers on which
        it is."""
        shapes = [(v, p) for v, p in zip(self.values, self.parameters, strict=True) if p.is_shape]
        sides = (float(v > p.barrier) for v, p in shapes if p.barrier is not None)
        return (*(v for v, p in shapes if not p.estimated), *sides)

    @property
    def family(self) -> Hashable:
        """What it shares with other points of its grid that would be refined alike; None where a grid suffices."""
        return None

    def refine(self, gradients: Sequence[ForceGradient]) -> Iterator[Self]:
        """Further points of its grid, read off the misfit; for one of each family."""
        yield from ()


@dataclass(frozen=True, slots=True)
class EffectCandidate(Candidate):
    """An effect of the catalogue at its null. Its columns come from the joint as it is, by either of two ways."""

    @property
    def is_late(self) -> bool:
        """Whether it only makes a signal late, whole or smoothed."""
        return False

    @classmethod
    def forces(cls, group: Sequence[Self], motion: Trajectory, record: Record) -> Array:
        """Generalised forces [Nm] that the scored parameters of a group of its kind add, per unit, mean over the
        intervals, (nv, q, n); q = 0 for what acts otherwise. motion : at the measured angle."""
        return np.zeros((motion.joint.masses, 0, len(record)))

    @classmethod
    def columns(cls, group: Sequence[Self], motion: Trajectory, output: Quantity, driven: Array) -> Array:
        """What the scored parameters of a group of its kind add to the output, per unit, (k, n). motion : as simulated,
        its angle kept; driven (q, n) : what the forces do to the output."""
        return driven


def scored_parameters(group: Sequence[Candidate]) -> int:
    """How many columns a group of candidates has."""
    return sum(len(c.scored) for c in group)


def columns_of(candidates: Sequence[Candidate]) -> Iterator[slice]:
    """Where the columns of each candidate are among those of all."""
    first = 0
    for one in candidates:
        yield slice(first, first + len(one.scored))
        first += len(one.scored)
