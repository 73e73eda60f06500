"""Tasks that other processes do, for tests."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from robotid.errors import NumericsError
from robotid.interrupt import Interrupted, check
from robotid.model.array import Array
from robotid.parallel import process as in_process


def square_sum(shared: Array, rows: int) -> float:
    """Sum of squares of some columns' rows: a matrix product, whose rounding depends on how its factors lie."""
    part = shared[:rows]
    return float(np.sum(part @ part.T))


def scaled(shared: Array, factor: int) -> tuple[str, Array]:
    """A large result, not contiguous."""
    return f"times {factor}", (factor * shared).T


def scaled_on_a_full_disk(shared: Array, factor: int) -> tuple[str, Array]:
    """The same where no file can be written."""

    def full(*_: object) -> bool:
        raise OSError("no space left on device")

    in_process.write = full  # of this process, which does nothing else
    return scaled(shared, factor)


def process(shared: None, number: int) -> int:
    """Number of the process that does the task."""
    return os.getpid()


def process_of_pair(shared: str, number: int) -> int:
    """Number of the process that does the task; the second of two is not done before the first, so that whoever is at
    it cannot take both. shared : a file that the first makes."""
    if number == 0:
        Path(shared).touch()
    wait_for(Path(shared))
    return os.getpid()


def wait_for(file: Path) -> None:
    """Return once a task has made a file. Raises TimeoutError after a minute."""
    for _ in range(6000):
        if file.exists():
            return
        time.sleep(0.01)
    raise TimeoutError(f"{file}: no task has made it in a minute")


def deaf(shared: None, number: int) -> bool:
    """Whether the process that does the task was born with interrupts blocked."""
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def refused(shared: None, number: int) -> int:
    """A task that fails where it is asked for an odd number."""
    if number % 2:
        raise NumericsError(f"{number} is odd", where="here", hint="ask for another")
    return number


def reported(shared: None, number: int, log: Callable[[int], None]) -> int:
    """A task that reports three times."""
    for k in range(3):
        log(10 * number + k)
    return number


def endless(shared: None, number: int) -> int:
    """A task that ends early where it is interrupted, and else not at all."""
    if number == 0:
        return 0
    try:
        while True:
            check()
            time.sleep(0.01)
    except Interrupted:
        return -number


def endless_once_begun(shared: str, number: int) -> int:
    """The same, telling by a file that it has begun."""
    Path(shared).touch()
    return endless(None, number)


def killed(shared: int, number: int) -> int:
    """A task that kills its process, unless that is the one that asked."""
    if os.getpid() != shared:
        os._exit(1)
    return number


def written_to(shared: Array, number: int) -> bool:
    """Whether a task may write to what it is given."""
    return bool(shared.flags.writeable)
