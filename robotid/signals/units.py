"""Units that recordings come in, converted to SI once, at the border."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from math import pi

from robotid.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Unit:
    """What a unit measures, and how it becomes the unit inside: factor times the number, plus zero. That is SI, and
    degrees Celsius for temperatures. A raw quantity becomes SI only by a column's scale."""

    name: str
    quantity: str
    factor: float
    zero: float = 0.0

    @property
    def raw(self) -> bool:
        return self.quantity in RAW


RAW = ("voltage", "current", "share", "count")
"""What a drive records instead of a torque or an angle."""

_FACTORS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180, "mdeg": pi / 180e3, "arcmin": pi / 10800, "rev": 2 * pi},
    "angular speed": {
        "rad/s": 1.0,
        "mrad/s": 1e-3,
        "deg/s": pi / 180,
        "mdeg/s": pi / 180e3,
        "rev/s": 2 * pi,
        "rpm": pi / 30,
    },
    "torque": {"Nm": 1.0, "mNm": 1e-3, "Nmm": 1e-3, "Ncm": 1e-2, "kNm": 1e3},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6, "m/min": 1 / 60, "mm/min": 1e-3 / 60},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "voltage": {"V": 1.0, "mV": 1e-3},
    "current": {"A": 1.0, "mA": 1e-3},
    "share": {"%": 1.0},
    "count": {"counts": 1.0},
    "temperature": {"degC": 1.0, "K": 1.0, "degF": 5 / 9},
    "inertia": {"kg m2": 1.0},
}
_ZEROS = {"K": -273.15, "degF": -32 * 5 / 9}
UNITS = {
    name: Unit(name, quantity, factor, _ZEROS.get(name, 0.0))
    for quantity, units in _FACTORS.items()
    for name, factor in units.items()
}

_SPELLINGS = {
    "deg": "° º degree degrees grad winkelgrad gradi grado grados degre degres degré degrés",
    "deg/s": "dps degs",
    "rev": "turn turns tr tour tours giro giri revolution revolutions umdrehung umdrehungen",
    "rpm": "rev/min r/min u/min 1/min /min upm tr/min giri/min umdrehungen/min umdrehung/min",
    "rad/s": "rads",
    "s": "sec secs second seconds sekunde sekunden seconde secondes segundo segundos secondo secondi",
    "ms": "msec millisecond milliseconds",
    "us": "usec microsecond microseconds",
    "V": "volt volts",
    "A": "amp amps ampere amperes",
    "%": "percent pct",
    "counts": "count inc incs increments ticks tick",
    "Nm": "newtonmeter newtonmetre",
    "N": "newton",
    "rad": "radian radians",
    "degC": "°c celsius",
    "K": "kelvin",
    "degF": "°f fahrenheit",
    "kg m2": "kgm2 kgm^2 kgm²",
}
_KNOWN = {name.lower(): unit for name, unit in UNITS.items()}
_KNOWN |= {spelling: UNITS[name] for name, spellings in _SPELLINGS.items() for spelling in spellings.split()}

SI = {
    False: {"time": "s", "torque": "Nm", "angle": "rad", "angular speed": "rad/s"},
    True: {"time": "s", "force": "N", "length": "m", "speed": "m/s"},
}
"""Quantity to its SI unit, of an axis that turns and of one that slides."""


def parse(text: str) -> Unit | None:
    """The unit that a text names, in the spellings that people use (deg/sec, °/s, N m, 1/min), or None."""
    if text in UNITS:
        return UNITS[text]
    plain = text.lower().replace("µ", "u").replace("μ", "u").replace("_per_", "/").replace(" per ", "/")
    plain = re.sub(r"[\s.*·]", "", plain)
    plain = re.sub(r"(?:\^-1|\^\(-1\)|-1|⁻¹)$", "", re.sub(r"(s|min)(?=\^-1|\^\(-1\)|-1$|⁻¹)", r"/\1", plain))
    if plain not in _KNOWN and "/" in plain:
        plain = "/".join(_KNOWN[part].name.lower() if part in _KNOWN else part for part in plain.split("/"))
    return _KNOWN.get(plain)


def unit(text: str, where: str) -> Unit:
    """The unit that a text names. Raises ConfigError for an unknown one."""
    found = parse(text)
    if found is not None:
        return found
    close = get_close_matches(text.lower(), _KNOWN, 1, 0.5)
    hint = f"did you mean {_KNOWN[close[0]].name}?" if close else "known are " + ", ".join(UNITS)
    raise ConfigError(f'there is no unit "{text}"', where=where, hint=hint)
