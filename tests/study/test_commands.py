"""Long studies are in no test, but what they import is there."""

from __future__ import annotations

from importlib import import_module
from pkgutil import walk_packages

import chaos
import compatibility
import pytest

import study

MODULES = [
    module.name
    for package in (study, chaos, compatibility)
    for module in walk_packages(package.__path__, f"{package.__name__}.")
    if ".test_" not in module.name
]


@pytest.mark.parametrize("module", MODULES)
def test_every_module_can_be_imported(module: str) -> None:
    import_module(module)
