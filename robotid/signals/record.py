"""A recording of one experiment, in SI units, the same whether measured or simulated."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from robotid.display import Displayed
from robotid.errors import ConfigError
from robotid.model.array import Array

SHORTEST_PIECE = 20  # samples

Role = Literal["estimate", "validate"]
Use = Literal["rigid", "flex", "both"]
Quantity = Literal["speed", "position"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Record(Displayed):
    """One experiment. All signals are on the motor side unless they end in _a, and (n,).

    tau_m is held from its sample to the next. ref is the controller's reference, of the quantity ref_kind names.
    period [s] is set where the excitation repeats; band [Hz] where it fills a known band. begin [s] : time of the first
    sample, other than zero for a piece of an experiment.
    """

    name: str
    role: Role
    use: Use
    sampling_time: float = field(metadata={"unit": "s"})
    tau_m: Array = field(metadata={"unit": "Nm"})
    phi_m: Array = field(metadata={"unit": "rad"})
    dphi_m: Array = field(metadata={"unit": "rad/s"})
    phi_a: Array | None = field(default=None, metadata={"unit": "rad"})
    ref: Array | None = field(default=None, metadata={"unit": "rad or rad/s"})
    ref_kind: Quantity | None = None
    period: float | None = field(default=None, metadata={"unit": "s"})
    band: tuple[float, float] | None = field(default=None, metadata={"unit": "Hz"})
    begin: float = field(default=0.0, metadata={"unit": "s"})

    def __len__(self) -> int:
        return len(self.tau_m)

    @property
    def t(self) -> Array:
        """Time since the experiment began [s], (n,)."""
        return self.begin + np.arange(len(self), dtype=np.float64) * self.sampling_time

    @property
    def duration(self) -> float:
        """Length of the record [s]."""
        return len(self) * self.sampling_time

    def piece(self, first: int, last: int) -> Record:
        """Samples first .. last - 1 as a record of the same name, no longer periodic."""
        cut = {
            name: signal[first:last]
            for name in ("tau_m", "phi_m", "dphi_m", "phi_a", "ref")
            if (signal := getattr(self, name)) is not None
        }
        return replace(self, period=None, begin=self.begin + first * self.sampling_time, **cut)

    def pieces(self, length: float) -> tuple[Record, ...]:
        """Consecutive pieces of about this length [s], none shorter than half of it. Raises ConfigError where that is
        hardly a sample."""
        if length < SHORTEST_PIECE * self.sampling_time:
            what = f"{length:g} s are fewer than {SHORTEST_PIECE} samples of {self.name}"
            raise ConfigError(what, where="horizon", hint="give a longer one, or none")
        count = max(1, round(self.duration / length))
        edges = np.linspace(0, len(self), count + 1).round().astype(int).tolist()
        return tuple(self.piece(a, b) for a, b in pairwise(edges))
