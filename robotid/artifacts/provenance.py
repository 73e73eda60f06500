"""Where an artifact comes from: enough to recognise a stale one, and to make it again."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime

import h5py
import numpy as np
import scipy

from robotid import __version__


def now() -> str:
    """The time in UTC, ISO 8601, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def environment() -> dict[str, str]:
    """What the numbers may depend on besides the inputs. Names neither the user nor the machine."""
    return {
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "h5py": h5py.__version__,
    }


@dataclass(frozen=True, slots=True)
class Provenance:
    """How an artifact was made, by default by this process and now.

    sections : of the configuration that count, as canonical text, and inputs : what was read, by name, as SHA-256; with
    the version these decide what is fresh. configuration : the whole of it, resolved. interrupted : it holds what was
    reached, and does not count as done. failed : demands of the configuration that the content misses, as sentences.
    """

    stage: str
    command: str
    sections: dict[str, str]
    inputs: dict[str, str]
    configuration: str
    seed: int | None = None
    interrupted: bool = False
    failed: tuple[str, ...] = ()
    version: str = __version__
    created: str = field(default_factory=now)
    environment: dict[str, str] = field(default_factory=environment)

    def contradictions(self) -> Iterator[str]:
        """What cannot be, as sentences: for one that was read from a file."""
        with suppress(ValueError):
            if datetime.fromisoformat(self.created).tzinfo is not None:
                return
        yield f"it was made at {self.created!r}, which is no time"


def digest(data: bytes) -> str:
    """SHA-256 as text."""
    return hashlib.sha256(data).hexdigest()


def content_digest(group: h5py.Group) -> str:
    """SHA-256 of all that a group holds: names, values and attributes, whatever their order and packing in the file."""
    total = hashlib.sha256()
    names: list[str] = []
    group.visit(names.append)
    for name in sorted(names):
        node = group[name]
        attributes = {key: np.asarray(node.attrs[key]).tolist() for key in sorted(node.attrs)}
        total.update(repr((name, attributes)).encode())
        for part in _parts(node):
            total.update(part)
    return total.hexdigest()


def _parts(node: h5py.Group | h5py.Dataset) -> Iterator[bytes | memoryview]:
    if isinstance(node, h5py.Group) or node.shape is None:
        return
    if h5py.check_string_dtype(node.dtype):
        yield repr(np.asarray(node.asstr()[()]).tolist()).encode()
    else:
        yield repr((node.shape, node.dtype.str)).encode()
        yield np.ascontiguousarray(node[()]).data
