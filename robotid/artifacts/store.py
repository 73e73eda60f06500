"""Artifacts on disk: whole or absent, checked when read.

An artifact is an HDF5 file behind a user block of 512 bytes, which HDF5 leaves to its user. The block holds a signature
and the SHA-256 of all that follows, so that one pass over the bytes, without HDF5, finds any damage.

The artifact of a single joint holds its content and where that comes from; that of a robot of several axes holds
both for each axis, in a group of its name.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Generic, TypeVar

import h5py

from robotid.artifacts.codec import CodecError, Units, length, read, write
from robotid.artifacts.consistency import mismatches
from robotid.artifacts.layout import layout_digest
from robotid.artifacts.provenance import Provenance, content_digest
from robotid.errors import ConfigError, InputError, printable
from robotid.files import atomic_write

FORMAT = 2  # 1 had no user block
BLOCK = 512  # [bytes] of the user block; HDF5 allows powers of two from here on
SIGNATURE = re.compile(rb"robotid artifact, format (\d+)\n")
AXES = "axes"
FORMER_MARK = "robotid artifact"  # the attribute `format` of format 1
NAMES = ("name", "record", "unit", "units", "symbol", "effect", "against", "along", "model", "twins")
"""Fields that name what the reports show."""
LONGEST_NAME = 2000  # characters: the base parameters of a robot are sums of many names
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


@dataclass(frozen=True, slots=True)
class Made:
    """What is to be saved. units : what a declared unit is called here."""

    content: object
    provenance: Provenance
    units: Units = str


def save(path: Path, content: object, provenance: Provenance, units: Units = str) -> None:
    """Write an artifact so that the file is whole or as it was. units : what a declared unit is called here.

    Raises InputError where it cannot be written.
    """
    made = Made(content, provenance, units)
    _write(path, lambda file: _write_entry(file, made))


def save_axes(path: Path, made: Mapping[str, Made], axes: Sequence[str]) -> None:
    """Write the artifact of a robot of several axes so that the file is whole or as it was. made : by axis; of the
    others among `axes`, the file keeps what it holds.

    Raises InputError where it cannot be written.
    """
    with ExitStack() as stack:
        kept: h5py.Group | None = None
        if path.is_file() and set(axes) - set(made):
            with suppress(InputError):  # what is damaged is lost already
                kept = stack.enter_context(_open(path)).get(AXES)
        _write(path, lambda file: _write_axes(file.create_group(AXES, track_order=True), made, axes, kept))


def _write_axes(group: h5py.Group, made: Mapping[str, Made], axes: Sequence[str], kept: h5py.Group | None) -> None:
    for axis in axes:
        if axis in made:
            _write_entry(group.create_group(axis), made[axis])
        elif kept is not None and axis in kept:
            kept.copy(axis, group)


def load(path: Path, cls: type[T], axis: str = "") -> Artifact[T]:
    """Read an artifact of a known class. axis : which one of a robot of several.

    Raises InputError where it is missing, foreign, damaged or of another format, class or layout, ConfigError where it
    has no such axis.
    """
    with _open(path) as file:
        return _load(path, _entry(path, file, axis), cls)


def load_axes(path: Path, cls: type[T], axes: Sequence[str]) -> dict[str, Artifact[T]]:
    """The same of several axes in one reading of the file."""
    with _open(path) as file:
        return {axis: _load(path, _entry(path, file, axis), cls) for axis in axes}


def _load(path: Path, entry: h5py.Group, cls: type[T]) -> Artifact[T]:
    header = _header(path, entry)
    if header.kind != cls.__name__:
        held, wanted = _words(header.kind), _words(cls.__name__)
        raise InputError(f"this holds {held}, not {wanted}", where=str(path), hint=AGAIN)
    try:
        content = read(_group(entry, "content"), cls)
        _require_names(content)
        _require_consistency(content)
        return Artifact(content, header)
    except UNREADABLE as error:
        raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def _words(kind: str) -> str:
    """The name of a class of contents as words."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", kind).lower()


def read_header(path: Path, axis: str = "") -> ArtifactHeader:
    """The header alone, of whatever kind; the whole file is checked. Raises as `load` does."""
    with _open(path) as file:
        return _header(path, _entry(path, file, axis))


def read_headers(path: Path) -> dict[str, ArtifactHeader]:
    """The header of every axis by its name, "" for a single joint. Raises InputError as `load` does."""
    version = None
    with suppress(OSError):  # opening it says what is wrong
        now = path.stat()
        version = now.st_ino, now.st_mtime_ns, now.st_size
    return dict(_headers(path, version))


@lru_cache(maxsize=64)
def _headers(path: Path, version: tuple[int, ...] | None) -> dict[str, ArtifactHeader]:
    """The headers of a file, which a command asks for many times. version : what changes where the file does."""
    with _open(path) as file:
        return {axis: _header(path, _entry(path, file, axis)) for axis in _axes(path, file) or ("",)}


def _axes(path: Path, file: h5py.File) -> tuple[str, ...]:
    """The axes that an artifact holds, none of a single joint."""
    if AXES not in file:
        return ()
    try:
        return tuple(_group(file, AXES))
    except UNREADABLE as error:
        raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def _entry(path: Path, file: h5py.File, axis: str) -> h5py.Group:
    """The group that holds the content of an axis, or of a single joint."""
    known = _axes(path, file)
    if axis in known:
        return _group(_group(file, AXES), axis)
    if not axis and not known:
        return file
    what = f'it holds no axis "{axis}"' if axis else f"it is of several axes: {', '.join(known)}"
    hint = (
        "choose one with --axis" if not axis else f"it holds {', '.join(known)}" if known else "it is of a single joint"
    )
    raise ConfigError(what, where=str(path), hint=hint)


def count_entries(path: Path, field: str, axis: str = "") -> int:
    """How many entries a tuple of the content has, read without the class of the content. Raises as `load` does, and
    InputError where the content has no such tuple."""
    with _open(path) as file:
        entry = _entry(path, file, axis)
        try:
            node = _group(entry, "content")[field]
            return length(node) if isinstance(node, h5py.Group) else int(node.shape[0])
        except UNREADABLE as error:
            raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def _user_block(body: bytes | memoryview) -> bytes:
    text = f"robotid artifact, format {FORMAT}\nsha256 {hashlib.sha256(body).hexdigest()}\n"
    return text.encode().ljust(BLOCK, b"\n")


def _write(path: Path, fill: Callable[[h5py.File], None]) -> None:
    """Write an HDF5 file, made in memory, so that all that can go wrong on the disk goes wrong in one place."""
    with h5py.File("artifact", "w", driver="core", backing_store=False, block_size=2**20) as file:
        fill(file)
        file.flush()
        body: bytes = file.id.get_file_image()
    atomic_write(path, _user_block(body) + body, hint=ELSEWHERE)


def _write_entry(entry: h5py.Group, made: Made) -> None:
    """Write what was made, and what it states about itself, into an empty group."""
    group = entry.create_group("content")
    write(group, made.content, made.units)
    write(entry.create_group("provenance"), made.provenance)
    entry.attrs.update(
        {
            "kind": type(made.content).__name__,
            "digest": content_digest(group),
            "layout": layout_digest(type(made.content)),
        }
    )


def _open(path: Path) -> h5py.File:
    """The HDF5 file once its bytes are known to be those that were written."""
    if path.is_dir():
        raise InputError("this is a folder", where=str(path), hint="name an artifact in it, such as model.h5")
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


def _header(path: Path, entry: h5py.Group) -> ArtifactHeader:
    try:
        kind, digest, layout = (str(entry.attrs[name]) for name in ("kind", "digest", "layout"))
        provenance = read(_group(entry, "provenance"), Provenance)
        _require_consistency(provenance)
        return ArtifactHeader(kind, digest, layout, provenance)
    except UNREADABLE as error:
        raise InputError(f"of another version ({_first_line(error)})", where=str(path), hint=AGAIN) from error


def _require_consistency(content: Any) -> None:
    """Raises CodecError where parts of a content contradict each other."""
    for mismatch in mismatches(content):
        raise CodecError(mismatch)


def _require_names(content: Any, *, named: bool = False) -> None:
    """Raises CodecError where a name in a content, or the key of a mapping, has characters that no name has, or is
    longer than any: names become identifiers in pages, cells of tables, and labels of figures. named : of a tuple,
    whether its words are names."""
    if is_dataclass(content):
        parts = [(field.name in NAMES, getattr(content, field.name)) for field in fields(content)]
    elif isinstance(content, Mapping):
        parts = [(True, key) for key in content] + [(False, value) for value in content.values()]
    elif isinstance(content, tuple):
        parts = [(named, value) for value in content]
    else:
        return
    for is_name, part in parts:
        if is_name and isinstance(part, str) and _is_no_name(part):
            raise CodecError(f"{part!r} is no name")
        _require_names(part, named=is_name)


def _is_no_name(word: str) -> bool:
    return len(word) > LONGEST_NAME or UNSAFE.search(word) is not None or printable(word) != word


def _group(parent: h5py.Group, name: str) -> h5py.Group:
    """A group that a file itself, or a group in it, holds."""
    if not isinstance(parent.get(name, getlink=True), h5py.HardLink):
        raise CodecError(f"it holds no {name}")
    return parent[name]


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].strip("'\"")
