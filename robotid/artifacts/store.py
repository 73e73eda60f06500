"""Artifacts on disk: whole or absent, checked when read."""

from __future__ import annotations

import os
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
ELSEWHERE = "check its folder and the space left, or give another --out"
DAMAGED = (AttributeError, CodecError, KeyError, OSError, RuntimeError, TypeError, ValueError)
"""What reading raises where bytes are not as they were written."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Label:
    """What an artifact says of itself. kind : class of the content; digest : SHA-256 of the content."""

    kind: str
    digest: str
    provenance: Provenance


@dataclass(frozen=True, slots=True)
class Artifact(Generic[T]):
    """What a stage made."""

    content: T
    label: Label

    @property
    def provenance(self) -> Provenance:
        """Where it comes from."""
        return self.label.provenance


def save(path: Path, content: object, provenance: Provenance, units: Units = str) -> None:
    """Write an artifact so that the file is whole or as it was. units : what a declared unit is called here.

    Raises InputError where it cannot be written.
    """
    _write(path, _image(content, provenance, units))


def write_text(path: Path, text: str, hint: str = ELSEWHERE) -> None:
    """Write a text file so that it is whole or as it was. Raises InputError, with this hint, where it cannot be
    written."""
    _write(path, text.encode(), hint)


def _write(path: Path, image: bytes, hint: str = ELSEWHERE) -> None:
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _replace(path, part, image)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", where=str(path), hint=hint) from error


def _replace(path: Path, part: Path, image: bytes) -> None:
    try:
        with part.open("wb") as file:
            file.write(image)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _image(content: object, provenance: Provenance, units: Units) -> bytes:
    """The bytes of the file. Made in memory, so that all that can go wrong on the disk goes wrong in one place."""
    with h5py.File("artifact", "w", driver="core", backing_store=False, block_size=2**20) as file:
        group = file.create_group("content")
        write(group, content, units)
        write(file.create_group("provenance"), provenance)
        file.attrs.update({"format": FORMAT, "schema": SCHEMA, "kind": type(content).__name__})
        file.attrs.update({"digest": content_digest(group), "provenance": content_digest(file["provenance"])})
        file.flush()
        image: bytes = file.id.get_file_image()
        return image


def load(path: Path, cls: type[T]) -> Artifact[T]:
    """Read an artifact of a known class. Raises InputError where it is missing, foreign, damaged or too new."""
    with _open(path) as file:
        label = _label(path, file)
        if label.kind != cls.__name__:
            raise InputError(f"this holds {label.kind}, not {cls.__name__}", where=str(path), hint=AGAIN)
        try:
            return Artifact(read(file["content"], cls), label)
        except DAMAGED as error:
            raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def read_header(path: Path, *, checked: bool = True) -> Label:
    """The label alone, of whatever kind. checked : the content, though not told, is held against its checksum. Raises
    InputError as `load` does."""
    with _open(path) as file:
        return _label(path, file, checked=checked)


def _open(path: Path) -> h5py.File:
    if not path.is_file():
        raise InputError("there is no such file", where=str(path), hint="run the stage that makes it")
    try:
        return h5py.File(path, "r")
    except PermissionError as error:
        raise InputError("it may not be read", where=str(path), hint="check its permissions") from error
    except OSError as error:
        raise InputError("this is not a readable HDF5 file: foreign or damaged", where=str(path), hint=AGAIN) from error


def _label(path: Path, file: h5py.File, *, checked: bool = True) -> Label:
    """What the file says of itself, where checked once its content is known to be what was written."""
    try:
        if file.attrs.get("format") != FORMAT:
            what, hint = "this HDF5 file was not made by robotid", "give an artifact of a run directory"
            raise InputError(what, where=str(path), hint=hint)
        schema = int(file.attrs["schema"])
        if schema != SCHEMA:
            hint = "install that version of robotid, or run its stage again" if schema > SCHEMA else AGAIN
            raise InputError(f"written in format {schema}, this version reads {SCHEMA}", where=str(path), hint=hint)
        if checked and content_digest(file["content"]) != file.attrs["digest"]:
            raise InputError("damaged: the content does not match its checksum", where=str(path), hint=AGAIN)
        if content_digest(file["provenance"]) != file.attrs["provenance"]:
            raise InputError("damaged: the provenance does not match its checksum", where=str(path), hint=AGAIN)
        return Label(str(file.attrs["kind"]), str(file.attrs["digest"]), read(file["provenance"], Provenance))
    except DAMAGED as error:
        raise InputError(f"damaged ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].strip("'\"")
