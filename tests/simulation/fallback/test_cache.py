"""The cache on disk is bounded, and holds whole files only."""

from __future__ import annotations

from collections.abc import Callable
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
        cached("0", (200,), lambda: np.zeros(200))
    assert not list(cache.glob("*"))


def test_the_cache_is_bounded_and_drops_the_oldest(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_disk, "MAX_SIZE", 5_000)
    for k in range(6):
        cached(str(k), (200,), lambda: np.zeros(200))
    kept = {file.name for file in cache.glob("*.npy")}
    assert sum(file.stat().st_size for file in cache.glob("*.npy")) <= 5_000
    assert "5.npy" in kept
    assert "0.npy" not in kept


def test_an_array_is_computed_once(cache: Path) -> None:
    first = cached("a", (3,), lambda: np.arange(3.0))
    assert np.array_equal(cached("a", (3,), lambda: np.zeros(3)), first)
    assert [file.name for file in cache.glob("*")] == ["a.npy"]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda content: content[:-1],
        lambda content: content[:-8] + bytes(8),
        lambda content: b"",
        lambda content: content.partition(b"\n")[2],
    ],
)
def test_a_file_that_is_not_as_it_was_written_is_computed_anew(spoil: Callable[[bytes], bytes], cache: Path) -> None:
    cached("a", (3,), lambda: np.arange(1.0, 4.0))
    (cache / "a.npy").write_bytes(spoil((cache / "a.npy").read_bytes()))
    assert np.array_equal(cached("a", (3,), lambda: np.full(3, 7.0)), np.full(3, 7.0))


def test_an_array_of_another_shape_or_kind_does_not_fit(cache: Path) -> None:
    cached("a", (3,), lambda: np.arange(3.0))
    assert np.array_equal(cached("a", (2, 2), lambda: np.eye(2)), np.eye(2))
    cached("b", (3,), lambda: np.arange(3))
    assert np.array_equal(cached("b", (3,), lambda: np.full(3, 7.0)), np.full(3, 7.0))
