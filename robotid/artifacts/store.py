"""Artifacts on disk: whole or absent, checked when read."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import h5py

from robotid.artifacts.codec import CodecError, Units, read, write
from robotid.artifacts.provenance import Provenance, content_digest
from robotid.errors import InputError

SCHEMA = 1
FORMAT = "robotid artifact"
AGAIN = "run its stage again"

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Artifact(Generic[T]):
    """What a stage made. kind : its class name; digest : SHA-256 of the content as written."""

    content: T
    provenance: Provenance
    digest: str = ""

    @property
    def kind(self) -> str:
        return type(self.content).__name__


@dataclass(frozen=True, slots=True)
class Label:
    """What can be read of an artifact without its content."""

    kind: str
    digest: str
    provenance: Provenance


def save(path: Path, artifact: Artifact[T], units: Units = str) -> str:
    """Write an artifact so that the file is whole or untouched; returns the digest of its content."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    os.close(handle)
    try:
        with h5py.File(name, "w") as file:
            content = file.create_group("content")
            write(content, artifact.content, units)
            write(file.create_group("provenance"), artifact.provenance)
            found = content_digest(content)
            file.attrs.update({"format": FORMAT, "schema": SCHEMA, "kind": artifact.kind, "digest": found})
        with open(name, "rb") as written:
            os.fsync(written.fileno())
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return found


def load(path: Path, cls: type[T]) -> Artifact[T]:
    """Read an artifact of a known class. Raises InputError where it is missing, foreign, damaged or too new."""
    with _open(path) as file:
        label = _label(path, file)
        if label.kind != cls.__name__:
            raise InputError(f"this holds {label.kind}, not {cls.__name__}", where=str(path), hint=AGAIN)
        try:
            if content_digest(file["content"]) != label.digest:
                raise InputError("the content does not match its checksum: damaged", where=str(path), hint=AGAIN)
            return Artifact(read(file["content"], cls), label.provenance, label.digest)
        except (CodecError, KeyError, OSError, ValueError) as error:
            raise InputError(f"damaged or of another version ({error})", where=str(path), hint=AGAIN) from error


def peek(path: Path) -> Label:
    """Kind, digest and provenance alone. Raises InputError as `load` does."""
    with _open(path) as file:
        return _label(path, file)


def _open(path: Path) -> h5py.File:
    if not path.is_file():
        raise InputError("there is no such file", where=str(path), hint="run the stage that makes it")
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise InputError("this is not a readable HDF5 file: foreign or damaged", where=str(path), hint=AGAIN) from error


def _label(path: Path, file: h5py.File) -> Label:
    if file.attrs.get("format") != FORMAT:
        raise InputError("this HDF5 file was not made by robotid", where=str(path), hint="give an artifact of a run directory")
    if int(file.attrs.get("schema", 0)) != SCHEMA:
        raise InputError(f"written in format {file.attrs['schema']}, this version reads {SCHEMA}", where=str(path), hint=AGAIN)
    try:
        return Label(str(file.attrs["kind"]), str(file.attrs["digest"]), read(file["provenance"], Provenance))
    except (CodecError, KeyError, OSError) as error:
        raise InputError(f"damaged ({error})", where=str(path), hint=AGAIN) from error
