"""Where a page and the artifacts that it shows come from: what its last section states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Source:
    """Where an artifact comes from."""

    stage: str
    file: str
    command: str
    version: str
    created: str
    digest: str
    inputs: Mapping[str, str]
    seed: int | None
    environment: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Origin:
    """Provenance of a page. stamp : digest of all that it shows; left_out : artifacts that it does not show, and why.
    configuration : the whole of it, resolved."""

    stamp: str
    configuration: str
    sources: tuple[Source, ...]
    left_out: Mapping[str, str]
