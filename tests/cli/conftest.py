"""What tests of the command line share."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paths import CONFIGS

from robotid.cli.app import main

SMOKE = CONFIGS / "smoke.yaml"


@pytest.fixture(scope="session")
def run_directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The configuration that CI runs, taken through all stages once; not to be written to."""
    out = tmp_path_factory.mktemp("smoke")
    assert main(["run", str(SMOKE), "--out", str(out), "--quiet"]) == 0
    return out
