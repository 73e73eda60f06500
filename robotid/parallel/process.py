"""What is done in another process."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from robotid.interrupt import Interrupted, asking, deadline
from robotid.parallel.crew import working
from robotid.parallel.sending import read, write

POLL = 0.02  # [s] between two questions whether a result is there, or still wanted
WATCH = 0.2  # [s] between two questions of a process whether it is still needed
GRACE = 3.0  # [s] in which a process that is not needed any more may end a task
LARGE = 1 << 20  # bytes of arrays in a result, from which a file is faster than a pipe


class _Unwanted(BaseException):
    """The result of a task is no longer wanted."""


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """A task that is asked of a process. file : what it shares with others; result : where it may leave its own;
    reports : where its reports go; until : the deadline."""

    task: Callable[..., Any]
    file: str
    item: Any
    result: str
    reports: str | None
    until: float | None


@dataclass(frozen=True, slots=True)
class Written:
    """A result that lies in a file."""

    file: str


_shared: dict[str, Any] = {}
"""The last shared object of a process, by its file: the next task asks for the same."""


def serve(asked: Asked) -> Any:
    """Do a task. Raises what it raises, and where the result is no longer wanted."""
    file, since, interrupted = Path(asked.file), time.monotonic(), False

    def still_wanted() -> None:
        nonlocal since, interrupted
        if time.monotonic() - since < POLL:
            return
        since = time.monotonic()
        if not file.exists():
            raise _Unwanted
        if not interrupted and Path(f"{file}-interrupted").exists():
            interrupted = True
            raise Interrupted

    if asked.file not in _shared:
        if not file.exists():
            raise _Unwanted
        _shared.clear()
        _shared[asked.file] = read(asked.file)
    with asking(still_wanted), deadline(asked.until), working(1):
        if asked.reports is None:
            return _returned(asked, asked.task(_shared[asked.file], asked.item))
        with open(asked.reports, "ab") as stream:
            return _returned(asked, asked.task(_shared[asked.file], asked.item, log=partial(_report, stream)))


def _returned(asked: Asked, result: Any) -> Any:
    """A result as it is handed back: in a file where it is large, if there is room for one."""
    file = Path(asked.result)
    try:
        return Written(asked.result) if write(file, result, LARGE) else result
    except OSError:
        file.unlink(missing_ok=True)
        return result


def _report(stream: Any, event: Any) -> None:
    stream.write(pickle.dumps(event))
    stream.flush()


def nothing() -> None:
    """The first task, with which a process starts."""


def begin(parent: int, folder: str, modules: Sequence[str]) -> None:
    """Prepare a process: an interrupt concerns its parent, and where that has gone it ends. Modules that tasks may need
    are imported while the parent still prepares the first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_watch, args=(parent, Path(folder)), name="watch", daemon=True).start()
    for name in modules:
        import_module(name)


def _watch(parent: int, folder: Path) -> None:
    """End the process once its parent has gone, or once the work is over and it does not end by itself."""
    while folder.exists() and os.getppid() == parent:
        time.sleep(WATCH)
    if os.getppid() == parent:
        time.sleep(GRACE)
    os._exit(0)
