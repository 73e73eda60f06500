"""Packages whose names are imported on first use."""

from __future__ import annotations

import importlib
import pkgutil

import pytest

PACKAGES = ("robotid", "robotid.diagnosis", "robotid.extension", "robotid.validation")


@pytest.mark.parametrize("package", PACKAGES)
def test_no_name_is_that_of_a_module_beside_it_which_would_take_its_place(package: str) -> None:
    module = importlib.import_module(package)
    beside = {m.name for m in pkgutil.iter_modules(module.__path__)}
    assert not beside & set(module.__all__)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_name_is_found_and_any_other_is_an_attribute_error(package: str) -> None:
    module = importlib.import_module(package)
    assert all(getattr(module, name) is not None for name in module.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nothing_of_the_kind'"):
        getattr(module, "nothing_of_the_kind")  # noqa: B009
