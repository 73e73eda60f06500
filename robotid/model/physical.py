"""What values of a parameter make physical sense on given records, as its effect declares it.

A fit turns whatever shape it is given into the one that explains most. One that lies outside what the motion can show,
or outside what the mechanism can do, imitates something else: a gearbox does not warm up in a second, and a Stribeck
speed that the motion never reaches is a constant.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

TURN = 2 * pi


@dataclass(frozen=True, slots=True)
class PortRange:
    """What records offer an effect at its place. duration [s] : of the longest record; speed [rad/s] : the largest;
    travel [rad] : the largest way from one end to the other within a record, of the angle that the effect goes round
    with."""

    duration: float
    speed: float
    travel: float


@dataclass(frozen=True, slots=True)
class Physical:
    """Where a parameter makes sense.

    least : in its own unit. of_duration : a least share of the longest record; enough : in its own unit, beyond which
    that share is not asked for. within_speed, within_travel : it is a speed or a way that the motion must reach.
    periods : it counts periods a turn, of which the motion must cover so many. bends : it is an inverse way, of which
    the motion must cover so many. why : what it would otherwise be, in words that follow its value.
    """

    why: str
    least: float = 0.0
    of_duration: float = 0.0
    enough: float = inf
    within_speed: bool = False
    within_travel: bool = False
    periods: float = 0.0
    bends: float = 0.0

    def range(self, offered: PortRange) -> tuple[float, float]:
        """Least and largest value that make sense on these records; without any travel, nothing is periodic."""
        low = max(self.least, min(self.of_duration * offered.duration, self.enough))
        if self.periods or self.bends:
            covered = max(self.periods * TURN, self.bends)
            low = max(low, covered / offered.travel if offered.travel > 0.0 else inf)
        high = min(
            offered.speed if self.within_speed else inf,
            offered.travel if self.within_travel else inf,
        )
        return low, high

    @property
    def text(self) -> str:
        """The range in words."""
        parts = []
        if self.least:
            parts.append(f"at least {self.least:g}")
        if self.of_duration:
            enough = f" or {self.enough:g}" if self.enough < inf else ""
            parts.append(f"at least {self.of_duration:g} of the longest record{enough}")
        if self.within_speed:
            parts.append("a speed that the motion reaches")
        if self.within_travel:
            parts.append("less than the motion travels")
        if self.periods:
            parts.append(f"the motion covers at least {self.periods:g} periods")
        if self.bends:
            parts.append(f"the motion covers its inverse at least {self.bends:g} times")
        return ", ".join(parts)
