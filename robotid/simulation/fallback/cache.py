"""Arrays on disk that took long to compute.

The cache holds plain .npy files named by a key that says everything that decides the answer. It is bounded in size
(the oldest files go first), safe to delete at any time, and lives in ROBOTID_CACHE, or robotid/ in the user's cache
folder.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.files import atomic_write
from robotid.model.array import Array

MAX_SIZE = 64_000_000  # bytes of all files together


def cached(key: str, compute: Callable[[], Array]) -> Array:
    """The array under this key, a name of a file, computed and kept where there is none that can be read."""
    file = cache_folder() / f"{key}.npy"
    try:
        return np.asarray(np.load(file, allow_pickle=False))
    except (EOFError, OSError, ValueError):
        x = compute()
    _store(file, x)
    return x


def cache_folder() -> Path:
    """Where the cache lives."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(os.environ.get("ROBOTID_CACHE") or Path(home) / "robotid")


def _store(file: Path, x: Array) -> None:
    image = BytesIO()
    np.save(image, x, allow_pickle=False)
    try:
        atomic_write(file, image.getvalue(), durable=False)
        _shrink(file.parent)
    except (InputError, OSError):
        return  # a cache that cannot be written costs time, not results


def _shrink(folder: Path) -> None:
    files = sorted(folder.glob("*.npy"), key=lambda f: f.stat().st_mtime)
    size = sum(f.stat().st_size for f in files)
    for file in files:
        if size <= MAX_SIZE:
            return
        size -= file.stat().st_size
        file.unlink(missing_ok=True)
