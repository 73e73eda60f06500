"""Units that recordings come in, converted to SI once, at the border."""

from __future__ import annotations

from difflib import get_close_matches
from math import pi

from robotid.errors import ConfigError

FACTORS: dict[str, float] = {
    **dict.fromkeys(("s", "rad", "rad/s", "Nm", "N", "m", "m/s", "V", "A", "1", ""), 1.0),
    "ms": 1e-3,
    "us": 1e-6,
    "min": 60.0,
    "mrad": 1e-3,
    "deg": pi / 180,
    "rev": 2 * pi,
    "mrad/s": 1e-3,
    "deg/s": pi / 180,
    "rev/s": 2 * pi,
    "rpm": 2 * pi / 60,
    "mNm": 1e-3,
    "kNm": 1e3,
    "kN": 1e3,
    "mN": 1e-3,
    "mm": 1e-3,
    "um": 1e-6,
    "mm/s": 1e-3,
    "mA": 1e-3,
    "mV": 1e-3,
}
"""Factor to SI. Volts and amperes become torque by the column's scale."""

SPELLINGS: dict[str, str] = {
    **dict.fromkeys(("°", "degree", "degrees"), "deg"),
    **dict.fromkeys(("deg/sec", "°/s", "dps"), "deg/s"),
    **dict.fromkeys(("N m", "N.m", "N*m", "N·m"), "Nm"),
    **dict.fromkeys(("1/min", "r/min", "U/min"), "rpm"),
    **dict.fromkeys(("sec", "second", "seconds"), "s"),
    **dict.fromkeys(("turn", "turns"), "rev"),
    **dict.fromkeys(("µs", "μs"), "us"),
}


def factor(unit: str, where: str) -> float:
    """Factor of a unit to SI. Raises ConfigError for an unknown one."""
    spelled = SPELLINGS.get(unit, unit)
    if spelled in FACTORS:
        return FACTORS[spelled]
    close = get_close_matches(spelled, [*FACTORS, *SPELLINGS], 1, 0.5)
    hint = f"did you mean {close[0]}?" if close else "known are " + ", ".join(u for u in FACTORS if len(u) > 1)
    raise ConfigError(f'there is no unit "{unit}"', where=where, hint=hint)


def is_known(unit: str) -> bool:
    """Whether a text is a unit."""
    return SPELLINGS.get(unit, unit) in FACTORS
