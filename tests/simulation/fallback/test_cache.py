"""The cache on disk is bounded, and holds whole files only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotid.simulation.fallback import cache as on_disk
from robotid.simulation.fallback.cache import cached


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ROBOTID_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_nothing_is_left_of_what_was_not_stored(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "save", interrupted)
    with pytest.raises(KeyboardInterrupt):
        cached("0", lambda: np.zeros(200))
    assert not list(cache.glob("*"))


def test_the_cache_is_bounded_and_drops_the_oldest(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_disk, "MAX_SIZE", 5_000)
    for k in range(6):
        cached(str(k), lambda: np.zeros(200))
    kept = {file.name for file in cache.glob("*.npy")}
    assert sum(file.stat().st_size for file in cache.glob("*.npy")) <= 5_000
    assert "5.npy" in kept
    assert "0.npy" not in kept


def test_an_array_is_computed_once(cache: Path) -> None:
    first = cached("a", lambda: np.arange(3.0))
    assert np.array_equal(cached("a", lambda: np.zeros(3)), first)
    assert [file.name for file in cache.glob("*")] == ["a.npy"]
