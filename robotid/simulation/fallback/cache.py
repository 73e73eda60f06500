"""Arrays on disk that took long to compute.

The cache holds .npy files named by a key that states everything that decides the answer, each behind a line with the
SHA-256 of the rest: what a crash left half, or somebody else put there, is computed anew. It is bounded in size
(the oldest files go first), safe to delete at any time, and lives in ROBOTID_CACHE, or robotid/ in the user's cache
folder.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.files import atomic_write, remove_leftovers
from robotid.model.array import Array

MAX_SIZE = 64_000_000  # bytes of all files together


def cached(key: str, shape: tuple[int, ...], compute: Callable[[], Array]) -> Array:
    """The array of this shape under this key, a name of a file, computed and kept where there is none that fits."""
    file = cache_folder() / f"{key}.npy"
    found = _stored(file, shape)
    if found is not None:
        return found
    x = compute()
    _store(file, x)
    return x


def _stored(file: Path, shape: tuple[int, ...]) -> Array | None:
    """The array of floats that a file holds, None where it holds none of this shape as it was written."""
    try:
        if file.stat().st_size > MAX_SIZE:
            return None
        content = file.read_bytes()
        head, _, image = content.partition(b"\n")
        if head != _digest(image):
            return None
        x = np.load(BytesIO(image), allow_pickle=False)
    except (EOFError, OSError, ValueError):
        return None
    return np.asarray(x) if x.shape == shape and x.dtype == np.float64 else None


def _digest(image: bytes) -> bytes:
    return hashlib.sha256(image).hexdigest().encode()


def cache_folder() -> Path:
    """Where the cache lives."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(os.environ.get("ROBOTID_CACHE") or Path(home) / "robotid")


def _store(file: Path, x: Array) -> None:
    image = BytesIO()
    np.save(image, x, allow_pickle=False)
    try:
        atomic_write(file, _digest(image.getvalue()) + b"\n" + image.getvalue(), durable=False)
        _shrink(file.parent)
    except (InputError, OSError):
        return  # a cache that cannot be written costs time, not results


def _shrink(folder: Path) -> None:
    remove_leftovers(folder)
    files = sorted(folder.glob("*.npy"), key=lambda f: f.stat().st_mtime)
    size = sum(f.stat().st_size for f in files)
    for file in files:
        if size <= MAX_SIZE:
            return
        size -= file.stat().st_size
        file.unlink(missing_ok=True)
