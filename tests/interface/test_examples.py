"""Every example in a docstring of the front door runs, and says what it claims."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

import robotid

MODULES = sorted({home for home in robotid._HOMES.values() if home.startswith("interface.")} | {"signals.record"})

NEEDS = {"interface.control_design": "control"}


@pytest.mark.parametrize("module", MODULES)
def test_examples_run(module: str, tmp_path: Path) -> None:
    if module in NEEDS:
        pytest.importorskip(NEEDS[module], reason=f"needs the extra {NEEDS[module]}")
    results = doctest.testmod(importlib.import_module(f"robotid.{module}"), extraglobs={"folder": tmp_path})
    assert results.failed == 0
    assert results.attempted > 0
