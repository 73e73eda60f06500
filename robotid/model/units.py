"""Units of a turning axis, and of a sliding one that the same equations describe."""

from __future__ import annotations

import re
from collections.abc import Callable

SLIDING = {"rad": "m", "rad2": "m2", "rad3": "m3", "Nm": "N", "Nm2": "N2", "kg m2": "kg"}
"""What a turning axis' units become; others stay."""
TURNING = re.compile(rf"\b({'|'.join(SLIDING)})\b")


def sliding(unit: str) -> str:
    """The unit of a turning axis as a sliding one has it: rad is m, Nm is N, kg m2 is kg. One that slides stays."""
    return TURNING.sub(lambda found: SLIDING[found[1]], unit)


def on_axis(*, linear: bool) -> Callable[[str], str]:
    """What a turning axis' unit is called on an axis that slides, or turns."""
    return sliding if linear else str


def unit_of(output: str, *, linear: bool) -> str:
    """Of a measured quantity, speed or position, on an axis that turns or slides."""
    return on_axis(linear=linear)("rad/s" if output == "speed" else "rad")
