"""Which trials there are under the conditions of real recordings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from study.plant.conditions import CONDITIONS
from study.plant.strangers import STRANGERS

EFFECTS = (
    "motor.stribeck",
    "motor.asymmetric_coulomb",
    "motor.quadratic_friction",
    "motor.cogging",
    "gear.soft_spring",
    "gear.backlash",
    "gear.hysteresis",
    "link.third_mass",
    "torque.torque_delay",
    "arm.coulomb",
)
"""One of every family of the catalogue."""
PLAIN = "white noise"
"""The condition of the white-noise study."""
BESIDE = "motor.stribeck"
"""The true effect beside a stranger."""


@dataclass(frozen=True, slots=True)
class Spec:
    """One trial. kind : clean, effect, stranger, or both (a stranger beside a true effect); name : what is hidden."""

    condition: str
    kind: str
    name: str
    number: int

    @property
    def key(self) -> str:
        """A name for files."""
        words = (self.condition, self.kind, self.name, str(self.number))
        return "-".join(word.replace(" ", "_").replace(".", "_").replace("'", "").replace("%", "pc") for word in words)

    def rng(self) -> np.random.Generator:
        """Everything that is drawn in the trial; the machine does not depend on the condition."""
        return np.random.default_rng([crc32(f"{self.kind} {self.name}".encode()), self.number])


def every(clean: int, draws: int, first: int = 0) -> Iterator[Spec]:
    """clean : draws of a machine without anything hidden under each condition; draws : of everything else; first :
    number of the first of both."""
    for number in range(first, first + max(clean, draws)):
        for condition in CONDITIONS:
            if number < first + clean:
                yield Spec(condition, "clean", "none", number)
            if number < first + draws:
                yield from (Spec(condition, "effect", name, number) for name in EFFECTS)
        if number < first + draws:
            yield from (Spec(PLAIN, kind, name, number) for name in STRANGERS for kind in ("stranger", "both"))
