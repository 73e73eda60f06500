"""Every example in a docstring of the front door runs, and says what it claims."""

from __future__ import annotations

import doctest
import importlib

import pytest

import robotid

MODULES = sorted({home for home in robotid._HOMES.values() if home.startswith("interface.")})


@pytest.mark.parametrize("module", MODULES)
def test_examples_run(module: str) -> None:
    results = doctest.testmod(importlib.import_module(f"robotid.{module}"), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert results.failed == 0
    assert results.attempted > 0
