"""Where an artifact comes from: enough to recognise a stale one, and to make it again."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

import h5py
import numpy as np
import scipy

from robotid import __version__


@dataclass(frozen=True, slots=True)
class Provenance:
    """How an artifact was made. sections : of the configuration that count, as canonical text, and inputs : what was
    read, by name, as SHA-256; both decide what is fresh. configuration : the whole of it, resolved."""

    stage: str
    version: str
    created: str
    sections: dict[str, str]
    inputs: dict[str, str]
    configuration: str
    seed: int | None
    environment: dict[str, str]


def provenance(
    stage: str, sections: Mapping[str, str], inputs: Mapping[str, str], configuration: str, seed: int | None
) -> Provenance:
    """Provenance of what this process makes now."""
    return Provenance(
        stage=stage,
        version=__version__,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        sections=dict(sections),
        inputs=dict(inputs),
        configuration=configuration,
        seed=seed,
        environment={
            "python": platform.python_version(),
            "platform": f"{platform.system()} {platform.machine()}",
            "numpy": np.__version__,
            "scipy": scipy.__version__,
            "h5py": h5py.__version__,
        },
    )


def digest(data: bytes) -> str:
    """SHA-256 as text."""
    return hashlib.sha256(data).hexdigest()


def content_digest(group: h5py.Group) -> str:
    """SHA-256 of all that a group holds: names, values and attributes, whatever their order in the file."""
    total = hashlib.sha256()

    def add(name: str, node: h5py.Group | h5py.Dataset) -> None:
        total.update(name.encode())
        for key in sorted(node.attrs):
            total.update(f"{key}={np.asarray(node.attrs[key]).tolist()!r}".encode())
        if isinstance(node, h5py.Dataset):
            value = node[()]
            total.update(value if isinstance(value, bytes) else np.ascontiguousarray(value).tobytes())

    names: list[str] = []
    group.visit(names.append)
    for name in sorted(names):
        add(name, group[name])
    return total.hexdigest()
