"""Hints of lower rooms, which name settings of the configuration, in terms of the front door."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from robotid.errors import RobotidError

SIGNALS = {
    "time": "t",
    "torque": "tau_m",
    "angle": "phi_m",
    "speed": "dphi_m",
    "arm_angle": "phi_a",
    "reference": "ref",
    "disturbance": "disturbance",
}
"""What `read` calls a signal, and what a record does."""


@contextmanager
def in_python_terms() -> Iterator[None]:
    """Raise errors with their hints in terms of the front door."""
    try:
        yield
    except RobotidError as error:
        raise type(error)(error.what, where=error.where, hint=in_python(error.hint)) from None


def in_python(hint: str) -> str:
    """A hint that names settings of the configuration, in terms of the front door."""
    words = {signal: key for key, signal in SIGNALS.items()}
    signal = "|".join(sorted(words, key=len, reverse=True))
    rules = (
        (r"widen init_flex\.band", "widen the band of rid.Options(band=...)"),
        (r"give one use: (rigid|flex)", r'read one with use="\1"'),
        (rf"write ({signal}): \{{name: (.+?), scale: \.\.\.\}}", r'write {0}=rid.Column("\2", scale=...)'),
        (
            rf"say which under columns: ({signal}), or that there is none, (?:{signal}): null",
            "say which by {0}=..., or that there is none by {0}=None",
        ),
        (rf"name the time column under columns: ({signal}), or give", "name the time column by {0}=..., or give"),
        (rf"(?:name it|say which) under columns: ({signal})\b", "name it by {0}=..."),
        (rf"write ({signal}): null under columns", "give {0}=None"),
        (rf"\b({signal}): null", "{0}=None"),
        (r"set repair: \{(\w+): (\w+)\}", r'give repair={"\1": "\2"}'),
        (r"speed_delay: (-?\d+)", r"speed_delay=\1"),
        (r"torque_delay: (-?[\d.e-]+)", r"torque_delay=\1"),
        (r"say which: \{name: (.+?), column: 0\}", r'say which: rid.Column("\1", column=0)'),
        (
            r"; a record's file is relative to the configuration|a record's file is relative to the configuration",
            "check the path",
        ),
    )
    for pattern, form in rules:
        found = re.search(pattern, hint)
        if found:
            key = words.get(found[1], "") if found.groups() else ""
            hint = hint[: found.start()] + found.expand(form.replace("{0}", key)) + hint[found.end() :]
    return hint
