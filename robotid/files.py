"""Files that are whole or as they were: the one place that replaces a file."""

from __future__ import annotations

import errno
import os
import re
from contextlib import suppress
from pathlib import Path

from robotid.errors import InputError

PART = re.compile(r"\..+\.(\d+)\.part")  # a temporary name, and the process that writes it
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


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files of processes that ended while they wrote into a folder of this machine."""
    with suppress(OSError):
        for file in folder.iterdir():
            found = PART.fullmatch(file.name)
            if found is not None and not _is_alive(int(found[1])):
                with suppress(OSError):
                    file.unlink()


def _is_alive(process: int) -> bool:
    if os.name != "posix" or process == os.getpid():
        return True  # elsewhere nobody can ask without ending it
    try:
        os.kill(process, 0)
    except OverflowError:
        return False
    except OSError as error:
        return error.errno != errno.ESRCH
    return True


def touch(path: Path, time: float | None = None) -> None:
    """Set the times of a file, by default to now, for programs that compare them. A file that one may only read keeps
    its own."""
    with suppress(OSError):
        os.utime(path, None if time is None else (time, time))


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
