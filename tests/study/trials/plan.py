"""Which trials there are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from zlib import crc32

import numpy as np

from study.plant.catalogue import EFFECTS, UNKNOWN

SIZES = {"small": 4.0, "large": 9.0}
"""What the effect costs in held-out residual, in noise standard deviations."""
DRAWS, CLEAN, PAIRS = 5, 50, 20
UNKNOWN_DRAWS = 2  # of each unknown effect at each size
TWINS = (
    {"torque.torque_delay", "torque.torque_lag", "speed.sensor_delay"},
    {"motor.constant_torque", "motor.asymmetric_coulomb", "arm.gravity"},
    {"gear.backlash", "gear.soft_spring"},
    {"motor.stribeck", "motor.presliding"},
    {"motor.viscous", "arm.viscous"},
    {"motor.coulomb", "arm.coulomb", "motor.presliding"},
)
"""Effects that usual data hardly tell apart; no pair is made of them, for it would look like one effect."""


@dataclass(frozen=True, slots=True)
class Spec:
    """One trial. kind : effect, clean, pair or unknown; names : of what is hidden; size : key of SIZES."""

    kind: str
    names: tuple[str, ...]
    size: str
    number: int

    @property
    def key(self) -> str:
        """A name for files."""
        return "-".join([self.kind, *(n.replace(".", "_") for n in self.names), self.size, str(self.number)])

    def rng(self) -> np.random.Generator:
        """Everything that is drawn in the trial."""
        return np.random.default_rng(crc32(self.key.encode()))


def every(draws: int = DRAWS, first: int = 0) -> Iterator[Spec]:
    """The whole study; fewer draws shorten all of it in proportion. first : number, by which draws differ that nobody
    has seen."""
    share = draws / DRAWS
    for number in range(first, first + draws):
        for name in EFFECTS:
            yield from (Spec("effect", (name,), size, number) for size in SIZES)
    yield from (Spec("clean", (), "none", number) for number in range(first, first + round(CLEAN * share)))
    for number in range(first, first + max(1, round(UNKNOWN_DRAWS * share))):
        for name in UNKNOWN:
            yield from (Spec("unknown", (name,), size, number) for size in SIZES)
    yield from (Spec("pair", pair, "small", k) for k, pair in enumerate(pairs(round(PAIRS * share)), first))


def pairs(count: int) -> list[tuple[str, str]]:
    """Pairs of effects that are not twins, the same at every call."""
    apart = [pair for pair in combinations(EFFECTS, 2) if not any(set(pair) <= twins for twins in TWINS)]
    order = np.random.default_rng(2005).permutation(len(apart))
    return [apart[k] for k in order[:count]]
