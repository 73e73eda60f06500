"""The configuration that CI runs, taken through all stages once, for tests that read what it leaves."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from robotid.cli.app import main

SMOKE = Path(__file__).parents[1] / "configs" / "smoke.yaml"
FOLDERS: list[TemporaryDirectory[str]] = []


@cache
def smoke_run() -> Path:
    """Its run directory; not to be written to."""
    FOLDERS.append(TemporaryDirectory(prefix="robotid-"))
    out = Path(FOLDERS[-1].name)
    assert main(["run", str(SMOKE), "--out", str(out), "--quiet"]) == 0
    return out
