"""Which trials there are: the first of two coupled axes is identified while both move."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from zlib import crc32

import numpy as np

KINDS = ("coupling", "pose", "friction", "temperature", "clean")
"""Left out of the model: coupling, inertia that the pose changes, a friction effect, temperature; nothing."""
FRICTION = ("stribeck", "asymmetric_coulomb", "quadratic_friction", "position_friction")
"""Friction effects in turn, by the number of the draw."""
DRAWS = 10


@dataclass(frozen=True, slots=True)
class Spec:
    """One trial."""

    kind: str
    number: int

    @property
    def key(self) -> str:
        """A name for files."""
        return f"{self.kind}-{self.number}"

    @property
    def friction(self) -> str:
        """The friction effect that is hidden, empty for none."""
        return FRICTION[self.number % len(FRICTION)] if self.kind == "friction" else ""

    def rng(self) -> np.random.Generator:
        """Everything that is drawn in the trial."""
        return np.random.default_rng([crc32(self.kind.encode()), self.number])


def every(draws: int) -> Iterator[Spec]:
    """So many draws of every kind, in turn."""
    return (Spec(kind, number) for number in range(draws) for kind in KINDS)
