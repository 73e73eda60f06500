"""What the controller has to follow, and all that an experiment's excitation is made of."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robotid.model.array import Array
from robotid.signals.record import Quantity


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A sampled reference of motor speed or position, ref (n,), of the quantity that kind names.

    period [s] after which it repeats, if it does within its length. A multisine's band and lines (k,) are the
    frequencies [Hz] that it excites; crest_factor is its own, whatever it is superposed on. block : the record of the
    configuration that asked for it; realisation : 1 for the first, which bears the block's name.
    """

    name: str
    sampling_time: float = field(metadata={"unit": "s", "positive": True})
    ref: Array = field(metadata={"unit": "rad or rad/s", "shape": ("n",), "finite": True})
    kind: Quantity
    period: float | None = field(default=None, metadata={"unit": "s", "positive": True})
    band: tuple[float, float] | None = field(default=None, metadata={"unit": "Hz", "positive": True})
    lines: Array = field(default_factory=lambda: np.zeros(0), metadata={"unit": "Hz", "shape": ("k",)})
    crest_factor: float | None = None
    block: str = ""
    realisation: int = 1

    def __len__(self) -> int:
        return len(self.ref)

    @property
    def t(self) -> Array:
        """Time from the first sample [s], (n,)."""
        return np.arange(len(self), dtype=np.float64) * self.sampling_time

    @property
    def duration(self) -> float:
        """Length [s]."""
        return len(self) * self.sampling_time


@dataclass(frozen=True, slots=True)
class Excitation:
    """All references, in the order of the configuration's records. others : those of the other axes of a robot whose
    axes move together, by axis, in the same order."""

    references: tuple[Reference, ...]
    others: dict[str, tuple[Reference, ...]] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Reference:
        return next(reference for reference in self.references if reference.name == name)
