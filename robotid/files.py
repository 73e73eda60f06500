"""Files that are whole or as they were: the one place that replaces a file."""

from __future__ import annotations

import os
from pathlib import Path

from robotid.errors import InputError

CHECK_FOLDER = "check its folder and the space left"


def atomic_write(path: Path, content: bytes | str, *, hint: str = CHECK_FOLDER, durable: bool = True) -> None:
    """Write a file, text as UTF-8, so that a reader finds either all of it or what was there before.

    The bytes go to a temporary file in the same folder, which is made where there is none, are flushed to the disk, and
    take the place of the old file in one step. durable : wait for the disk; False where a loss of power may cost the
    file. Raises InputError, with this hint, where it cannot be written.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _replace(path, part, content.encode() if isinstance(content, str) else content, durable)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", where=str(path), hint=hint) from error


def _replace(path: Path, part: Path, content: bytes, durable: bool) -> None:
    try:
        with part.open("wb") as file:
            file.write(content)
            if durable:
                file.flush()
                os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
