"""Every tuning constant of the diagnosis is seen by a check, which fails where the constant is changed noticeably."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import fields
from typing import Any

import pytest
import support.tuning
from support.tuning import CHECKS, FACTOR, changed, scaled

import robotid.diagnosis


def settings() -> list[Any]:
    """The settings of all rooms: every frozen dataclass of a module called settings."""
    names = [m.name for m in pkgutil.walk_packages(robotid.diagnosis.__path__, "robotid.diagnosis.")]
    modules = [importlib.import_module(name) for name in names if name.endswith(".settings")]
    return [one for m in modules for one in vars(m).values() if hasattr(one, "__dataclass_fields__") and one.__hash__]


for module in pkgutil.iter_modules(support.tuning.__path__):
    importlib.import_module(f"support.tuning.{module.name}")

INSTANCES = [one for one in settings() if not isinstance(one, type)]
CONSTANTS = [(one, field.name) for one in INSTANCES for field in fields(one)]


@pytest.mark.parametrize(("one", "name"), CONSTANTS, ids=[f"{type(s).__name__}.{n}" for s, n in CONSTANTS])
def test_a_check_notices_that_the_constant_is_changed(one: Any, name: str) -> None:
    assert (type(one).__name__, name) in CHECKS, f"no check in tests/support/tuning sees {name}"
    check = CHECKS[type(one).__name__, name]
    check()
    for factor in (FACTOR, 1 / FACTOR):
        with changed(one, name, scaled(getattr(one, name), factor)), pytest.raises(AssertionError):
            check()


def test_no_check_is_left_over() -> None:
    assert set(CHECKS) == {(type(one).__name__, name) for one, name in CONSTANTS}


def test_the_rooms_have_constants() -> None:
    assert len({type(one).__name__ for one in INSTANCES}) >= 7
