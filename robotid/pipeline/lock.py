"""One process at a time in a run directory: a second one waits, and says for whom."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType

from robotid.files import remove_leftovers
from robotid.interrupt import check

try:
    import fcntl as _fcntl

    fcntl: ModuleType | None = _fcntl
except ImportError:  # this system has no such locks
    fcntl = None

LOCK = ".robotid.lock"
POLL = 0.2  # [s] between two looks at a lock that another process holds


@contextmanager
def locked(folder: Path, command: str, remark: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of a run directory, which is made where there is none.

    command : what holds it, for others to read. remark : gets a sentence where another process is waited for. The
    system takes the lock from a process that ends, however it ends: a lock file that was left behind locks nothing. A
    directory that one may only read is not locked, nor is one of a file system without locks.
    """
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    descriptor = _acquire(folder, remark)
    if descriptor is None:
        yield
        return
    try:
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"process {os.getpid()}: {command}\n".encode(errors="backslashreplace"), 0)
        remove_leftovers(folder)
        yield
    finally:
        with suppress(OSError):
            (folder / LOCK).unlink()
        os.close(descriptor)
        with suppress(OSError):
            for place in made:
                place.rmdir()  # fails where there is anything in it


def _acquire(folder: Path, remark: Callable[[str], None]) -> int | None:
    """The open lock file, None where there can be none."""
    waiting = False
    while fcntl is not None:
        check()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError:
            return None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_current(descriptor, folder / LOCK):
                return descriptor
        except BlockingIOError:
            if not waiting:
                remark(f"{folder}: {_holder(descriptor)} works in it; waiting until that ends")
            waiting = True
            time.sleep(POLL)
        except OSError:
            os.close(descriptor)
            return None
        os.close(descriptor)
    return None


def _is_current(descriptor: int, file: Path) -> bool:
    """Whether an open lock file is still the one of that name: who held it has removed it."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(file))
    except OSError:
        return False


def _holder(descriptor: int) -> str:
    text = os.pread(descriptor, 500, 0).decode(errors="replace").strip()
    return text or "another process"
