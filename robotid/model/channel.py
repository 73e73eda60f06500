"""The second family of effects: a channel acts on a signal (torque, angle, speed) rather than as a torque."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from copy import copy
from typing import ClassVar, Self

from robotid.model.array import Array
from robotid.model.companion import CompanionKind, Course, with_companion
from robotid.model.parameters import Parameter
from robotid.model.port import Signal


class Channel(ABC):
    """An effect between a signal as recorded and as it acts (torque), or as it is and as recorded (angle, speed).

    A torque signal is constant between samples (zero-order hold): `apply` takes and returns its mean over each
    sampling interval. has_memory : what a held torque becomes within an interval depends on what it was before, so that
    it changes on the way; the simulation then applies the channel to parts of intervals. is_late : the signal only
    comes late, whole or smoothed, by the one parameter. companion : the kind of a further recorded signal that it
    depends on; which one, an instance says that `reading` has made, and `beside` gives it the course.
    """

    name: ClassVar[str]
    signals: ClassVar[tuple[Signal, ...]]
    parameters: ClassVar[tuple[Parameter, ...]]
    formula: ClassVar[str]
    source: ClassVar[str]
    signature: ClassVar[str]
    companion: ClassVar[CompanionKind | None] = None
    has_memory: ClassVar[bool] = False
    is_late: ClassVar[bool] = False
    companion_name: str = ""
    course: Course | None = None

    def reading(self, companion: str) -> Self:
        """The same effect as one that reads the companion of this name, which becomes part of its own name."""
        one = copy(self)
        vars(one).update(name=with_companion(self.name, companion), companion_name=companion)
        return one

    def beside(self, courses: Mapping[str, Course]) -> Self:
        """The same effect beside the companions of a record: itself where it reads none."""
        if not self.companion_name:
            return self
        one = copy(self)
        one.course = courses[self.companion_name]
        return one

    def on_parts(self, parts: int) -> Self:
        """The same effect on a signal with so many equal parts of each sampling interval as its samples."""
        if self.course is None or parts == 1:
            return self
        one = copy(self)
        one.course = self.course.in_parts(parts)
        return one

    @abstractmethod
    def apply(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        """The signal after the channel. signal : (n,) -> (n,)."""

    @abstractmethod
    def push(self, column: Array, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        """Directional derivative of `apply` in the signal. column : (..., n) -> (..., n)."""

    @abstractmethod
    def partials(self, signal: Array, sampling_time: float, p: Sequence[float]) -> Array:
        """Derivative of `apply` to each parameter, (p, n)."""
