"""The second family of effects: a channel acts on a signal (torque, angle, speed) rather than as a torque."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class Channel(ABC):
    """An effect between a signal as recorded and as it acts (torque), or as it is and as recorded (angle, speed).

    A torque signal is constant between samples (zero-order hold): `apply` takes and returns its mean over each
    sampling interval.
    """

    name: ClassVar[str]
    signals: ClassVar[tuple[Signal, ...]]
    parameters: ClassVar[tuple[Parameter, ...]]
    formula: ClassVar[str]
    source: ClassVar[str]
    signature: ClassVar[str]

    @abstractmethod
    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        """The signal after the channel. signal : (n,) -> (n,)."""

    @abstractmethod
    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        """Directional derivative of `apply` in the signal. column : (..., n) -> (..., n)."""

    @abstractmethod
    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        """Derivative of `apply` to each parameter, (p, n)."""
