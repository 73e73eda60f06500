"""Where the project's own files are, and the measured records beside it."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs"
SHARED = ROOT.parent / "shared" / "data"
"""Measured records of third parties; a test that needs one skips where they are absent."""
