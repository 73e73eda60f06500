"""Artifacts on disk: whole or absent, checked when read.

An artifact is an HDF5 file behind a user block of 512 bytes, which HDF5 leaves to its user. The block holds a signature
and the SHA-256 of all that follows, so that one pass over the bytes, without HDF5, finds any damage.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import h5py

from robotid.artifacts.codec import CodecError, Units, read, write
from robotid.artifacts.layout import layout_digest
from robotid.artifacts.provenance import Provenance, content_digest
from robotid.errors import InputError, printable
from robotid.files import atomic_write

FORMAT = 2  # 1 had no user block
BLOCK = 512  # [bytes] of the user block; HDF5 allows powers of two from here on
SIGNATURE = re.compile(rb"robotid artifact, format (\d+)\n")
FORMER_MARK = "robotid artifact"  # the attribute `format` of format 1
NAMES = ("name", "record")  # fields that name what the reports show
UNSAFE = re.compile(r"[<>\"&`]")
AGAIN = "run its stage again"
ELSEWHERE = "check its folder and the space left, or give another --out"
UNREADABLE = (
    *(AttributeError, CodecError, KeyError, MemoryError, OSError, OverflowError, RuntimeError, TypeError, ValueError),
    IndexError,
)
"""What reading raises where a file does not hold what it should."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class ArtifactHeader:
    """What an artifact states about itself. kind : class of the content; digest : SHA-256 of the content; layout : of
    the types of its fields."""

    kind: str
    digest: str
    layout: str
    provenance: Provenance


@dataclass(frozen=True, slots=True)
class Artifact(Generic[T]):
    """What a stage made."""

    content: T
    header: ArtifactHeader

    @property
    def provenance(self) -> Provenance:
        """Where it comes from."""
        return self.header.provenance


def save(path: Path, content: object, provenance: Provenance, units: Units = str) -> None:
    """Write an artifact so that the file is whole or as it was. units : what a declared unit is called here.

    Raises InputError where it cannot be written.
    """
    body = _hdf5(content, provenance, units)
    atomic_write(path, _user_block(body) + body, hint=ELSEWHERE)


def load(path: Path, cls: type[T]) -> Artifact[T]:
    """Read an artifact of a known class. Raises InputError where it is missing, foreign, damaged or of another format,
    class or layout."""
    with _open(path) as file:
        header = _header(path, file)
        if header.kind != cls.__name__:
            raise InputError(f"this holds {header.kind}, not {cls.__name__}", where=str(path), hint=AGAIN)
        try:
            content = read(_group(file, "content"), cls)
            _require_names(content)
            return Artifact(content, header)
        except UNREADABLE as error:
            raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def read_header(path: Path) -> ArtifactHeader:
    """The header alone, of whatever kind; the whole file is checked. Raises InputError as `load` does."""
    with _open(path) as file:
        return _header(path, file)


def count_entries(path: Path, field: str) -> int:
    """How many entries a tuple of the content has, read without the class of the content. Raises InputError as `load`
    does, and where the content has no such tuple."""
    with _open(path) as file:
        try:
            node = _group(file, "content")[field]
            return int(node.attrs["length"] if isinstance(node, h5py.Group) else node.shape[0])
        except UNREADABLE as error:
            raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def _user_block(body: bytes | memoryview) -> bytes:
    text = f"robotid artifact, format {FORMAT}\nsha256 {hashlib.sha256(body).hexdigest()}\n"
    return text.encode().ljust(BLOCK, b"\n")


def _hdf5(content: object, provenance: Provenance, units: Units) -> bytes:
    """The HDF5 file, made in memory, so that all that can go wrong on the disk goes wrong in one place."""
    with h5py.File("artifact", "w", driver="core", backing_store=False, block_size=2**20) as file:
        group = file.create_group("content")
        write(group, content, units)
        write(file.create_group("provenance"), provenance)
        file.attrs.update(
            {
                "kind": type(content).__name__,
                "digest": content_digest(group),
                "layout": layout_digest(type(content)),
            }
        )
        file.flush()
        image: bytes = file.id.get_file_image()
        return image


def _open(path: Path) -> h5py.File:
    """The HDF5 file once its bytes are known to be those that were written."""
    if not path.is_file():
        raise InputError("there is no such file", where=str(path), hint="run the stage that makes it")
    try:
        image = path.read_bytes()
    except PermissionError as error:
        raise InputError("it may not be read", where=str(path), hint="check its permissions") from error
    signature = SIGNATURE.match(image)
    if signature is None:
        raise _foreign(path)
    if int(signature[1]) != FORMAT:
        raise _other_format(path, int(signature[1]))
    if image[:BLOCK] != _user_block(memoryview(image)[BLOCK:]):
        raise InputError("damaged: the file does not match its checksum", where=str(path), hint=AGAIN)
    return h5py.File(path, "r")


def _foreign(path: Path) -> InputError:
    """The error for a file without the signature: no HDF5, not of this program, or of its first format."""
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") == FORMER_MARK:
                return _other_format(path, 1)
    except UNREADABLE:
        return InputError("this is not a readable HDF5 file: foreign or damaged", where=str(path), hint=AGAIN)
    what, hint = "this HDF5 file was not made by robotid", "give an artifact of a run directory"
    return InputError(what, where=str(path), hint=hint)


def _other_format(path: Path, found: int) -> InputError:
    hint = "install that version of robotid, or run its stage again" if found > FORMAT else AGAIN
    return InputError(f"written in format {found}, this version reads {FORMAT}", where=str(path), hint=hint)


def _header(path: Path, file: h5py.File) -> ArtifactHeader:
    try:
        kind, digest, layout = (str(file.attrs[name]) for name in ("kind", "digest", "layout"))
        return ArtifactHeader(kind, digest, layout, read(_group(file, "provenance"), Provenance))
    except UNREADABLE as error:
        raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def _require_names(content: Any) -> None:
    """Raises CodecError where a name in a content, or the key of a mapping, has characters that no name has: names
    become identifiers in pages, and cells of tables."""
    if is_dataclass(content):
        parts = [(field.name in NAMES, getattr(content, field.name)) for field in fields(content)]
    elif isinstance(content, Mapping):
        parts = [(True, key) for key in content] + [(False, value) for value in content.values()]
    elif isinstance(content, tuple):
        parts = [(False, value) for value in content]
    else:
        return
    for is_name, part in parts:
        if is_name and isinstance(part, str) and (UNSAFE.search(part) or printable(part) != part):
            raise CodecError(f"{part!r} is no name")
        _require_names(part)


def _group(file: h5py.File, name: str) -> h5py.Group:
    """A group that the file itself holds."""
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise CodecError(f"it holds no {name}")
    return file[name]


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].strip("'\"")
