"""Which effects a model has, as names alone: what configuration says and artifacts keep."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Structure:
    """A joint's make-up. terms such as "gear.spring", channels such as "torque.torque_delay", in order.

    gear_ratio is phi_a / phi_m, None for a rigid axis. linear : the axis slides (m, N, kg) rather than turns.
    """

    terms: tuple[str, ...]
    channels: tuple[str, ...] = ()
    gear_ratio: float | None = None
    linear: bool = False

    def extended(self, effect: str) -> Structure:
        """The same joint with one effect more; its first word tells a signal from a port."""
        if effect.split(".")[0] in ("torque", "angle", "speed"):
            return replace(self, channels=(*self.channels, effect))
        return replace(self, terms=(*self.terms, effect))
