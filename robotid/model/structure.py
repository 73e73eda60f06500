"""Which effects a model has, as names alone, as configurations and artifacts keep them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

RECORD_CHANGE = "record_change"


@dataclass(frozen=True, slots=True)
class Structure:
    """A joint's make-up. terms such as "gear.spring", channels such as "torque.torque_delay", in order.

    gear_ratio is phi_a / phi_m, None for a rigid axis. linear : the axis slides (m, N, kg) rather than turns. changes :
    parameters that differ in one record, such as "record_change.day2.arm.inertia.J". recorded_angle : beside a record,
    torques that depend on the motor's angle act at the recorded one; a simulated angle drifts with every error of the
    torque, and loses the phase of what repeats itself with it.
    """

    terms: tuple[str, ...]
    channels: tuple[str, ...] = ()
    gear_ratio: float | None = field(default=None, metadata={"finite": True})
    linear: bool = False
    changes: tuple[str, ...] = ()
    recorded_angle: bool = False

    @property
    def effects(self) -> tuple[str, ...]:
        """Terms, channels and changes."""
        return (*self.terms, *self.channels, *self.changes)

    def extended(self, effect: str) -> Structure:
        """The same joint with one effect more; its first word tells a signal from a port, and a change from either."""
        first = effect.split(".")[0]
        if first == RECORD_CHANGE:
            return replace(self, changes=(*self.changes, effect))
        if first in ("torque", "angle", "speed"):
            return replace(self, channels=(*self.channels, effect))
        return replace(self, terms=(*self.terms, effect))

    def without(self, effect: str) -> Structure:
        """The same joint with one effect less, and without changes of its parameters."""
        terms, channels, changes = (
            tuple(e for e in effects if e != effect) for effects in (self.terms, self.channels, self.changes)
        )
        changes = tuple(c for c in changes if not rests_on(c, effect))
        return replace(self, terms=terms, channels=channels, changes=changes)


def change(record: str, parameter: str) -> str:
    """The effect that a parameter differs in one record."""
    return f"{RECORD_CHANGE}.{record}.{parameter}"


def is_change(effect: str) -> bool:
    """Whether an effect is a parameter that differs in a record."""
    return effect.startswith(f"{RECORD_CHANGE}.")


def changed(effect: str) -> tuple[str, str]:
    """Record and parameter of a change."""
    record, *parameter = effect.removeprefix(f"{RECORD_CHANGE}.").rsplit(".", 3)
    return record, ".".join(parameter)


def belongs(parameter: str, effect: str) -> bool:
    """Whether a parameter, by dotted name, is an effect's own; a changed parameter is the change itself."""
    return effect in (parameter, parameter.rpartition(".")[0])


def rests_on(effect: str, other: str) -> bool:
    """Whether an effect is a change of another's parameter, and cannot be without it."""
    return is_change(effect) and changed(effect)[1].startswith(f"{other}.")
