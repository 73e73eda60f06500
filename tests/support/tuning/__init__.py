"""One check for every tuning constant of the diagnosis: it holds as the constant is, and fails where it is changed.

Each module has the checks of one room. A check is a function with assertions, tied to its constant by `sees`; that
every constant has one, and that it notices, is the promise of `promises/test_every_tuning_constant.py`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import Any

Check = Callable[[], None]
CHECKS: dict[tuple[str, str], Check] = {}
FACTOR = 3.0


def sees(settings: Any, name: str) -> Callable[[Check], Check]:
    """Ties a check to one constant."""
    assert name in {f.name for f in fields(settings)}, name

    def tie(check: Check) -> Check:
        CHECKS[type(settings).__name__, name] = check
        return check

    return tie


def scaled(value: Any, factor: float) -> Any:
    """A constant changed by a factor; a number of things by at least one."""
    if isinstance(value, tuple):
        return tuple(scaled(one, factor) for one in value)
    if isinstance(value, int):
        changed = round(value * factor)
        return changed if changed != value else value + (1 if factor > 1 else -1)
    return value * factor


@contextmanager
def changed(settings: Any, name: str, value: Any) -> Iterator[None]:
    """All modules of the diagnosis with one constant changed."""
    other = replace(settings, **{name: value})
    modules = [m for key, m in sys.modules.items() if key.startswith("robotid.diagnosis")]
    found = [(m, key) for m in modules for key, held in vars(m).items() if held is settings]
    for module, key in found:
        setattr(module, key, other)
    try:
        yield
    finally:
        for module, key in found:
            setattr(module, key, settings)
