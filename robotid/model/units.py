"""Units of a turning axis, and of a sliding one that the same equations describe."""

from __future__ import annotations

import re
from collections.abc import Callable

SLIDING = {"rad": "m", "rad2": "m2", "rad3": "m3", "Nm": "N", "Nm2": "N2", "kg m2": "kg"}
"""What a turning axis' units become; others stay."""
TURNING = re.compile(rf"\b({'|'.join(SLIDING)})\b")
TURNING_WORDS = re.compile(r"(?<![\w.])(?:([Tt])orque|([Mm]otor|[Aa]rm) angle)(?=s?\b)(?!\.\w)")
"""Words for a torque or an angle of the axis, not within the name of an effect or a key."""

UNITS = re.compile(
    r"(?<![\w.])(?:1/)?(?:{one})(?:(?:/|(?<=kg) |(?<=Nm) |(?<=N) )(?:{one}))*(?![\w\[])(?!\.\w)".format(
        one="(?:kg|Nm|N|rad|degC|deg|V|m|s)[2-9]?"
    )
)
NAME = re.compile(r"[msNV][2-9]?|[ms][2-9]/[ms][2-9]")
"""What may be a unit with a power, or a name, or two of them."""
POWER = re.compile(r"(?<=[A-Za-z])[2-9]\b")
RAISED = str.maketrans("23456789", "²³⁴⁵⁶⁷⁸⁹")


def sliding(unit: str) -> str:
    """The unit of a turning axis as a sliding one has it: rad is m, Nm is N, kg m2 is kg. One that slides stays."""
    return TURNING.sub(lambda found: SLIDING[found[1]], unit)


def sliding_words(text: str) -> str:
    """A text about a turning axis as one about a sliding axis: force and position where it says torque and angle; the
    names of effects stay."""
    return TURNING_WORDS.sub(_slid, text)


def _slid(found: re.Match[str]) -> str:
    if found[1]:
        return "Force" if found[1] == "T" else "force"
    return f"{found[2]} position"


def typeset(text: str) -> str:
    """A text for people, the powers of its units raised: rad/s2 is rad/s², kg m2 is kg m². What may be a name, such as
    m2 of a model, stays, unless it stands alone in brackets after a space. Files and JSON keep the plain units."""
    return UNITS.sub(_raised, text)


def _raised(found: re.Match[str]) -> str:
    bracketed = found.string[max(0, found.start() - 2) : found.start()].endswith((" [", "\n["))
    alone = bracketed and found.string[found.end() : found.end() + 1] == "]"
    return found[0] if NAME.fullmatch(found[0]) and not alone else typeset_unit(found[0])


def typeset_unit(unit: str) -> str:
    """A unit by itself, the powers of its units raised."""
    return POWER.sub(lambda found: found[0].translate(RAISED), unit)


def on_axis(*, linear: bool) -> Callable[[str], str]:
    """What a turning axis' unit is called on an axis that slides, or turns."""
    return sliding if linear else str


def unit_of(output: str, *, linear: bool) -> str:
    """Of a measured quantity, speed or position, on an axis that turns or slides."""
    return on_axis(linear=linear)("rad/s" if output == "speed" else "rad")
