"""Ctrl-C and SIGTERM: a signal sets a flag, and whoever works asks for it between two steps.

An exception that a signal raises wherever the program happens to be lands inside a library's callback, where it is
swallowed or taken for an error of that library. So the command line works within `interruptible`, long work calls
`check` at points where stopping is safe, and calls that may block for ever stand in `blocking`. A second signal ends
the process at once. Where nothing is `interruptible`, as in a notebook, Python's own KeyboardInterrupt stays as it is.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from types import FrameType

from robotid.errors import INTERRUPTED

SHOW_CURSOR = b"\x1b[?25h"  # what a live display hides
WIND_UP = 1.5  # [s] of work, for which a person who has interrupted waits so that a result is kept


class Interrupted(BaseException):
    """The process was asked to stop. No Exception, so that no handler of errors takes it for one."""


INTERRUPTS = (Interrupted, KeyboardInterrupt)
"""What ends an iteration that is interruptible with its last iterate."""


class OutOfTime(BaseException):
    """The time that was allowed has passed. No Exception, for the same reason."""


@dataclass(slots=True)
class _Requests:
    """Signals so far, whether one of them waits for a safe point, and how many blocking calls are under way."""

    received: int = 0
    pending: bool = False
    blocking: int = 0


_requests: _Requests | None = None
"""None where nothing is interruptible. A signal handler has no other way to reach the code that it interrupts."""


_until: ContextVar[float | None] = ContextVar("robotid.until", default=None)
_question: ContextVar[Callable[[], None] | None] = ContextVar("robotid.question", default=None)


def check() -> None:
    """A safe point. Raises Interrupted where a signal has asked to stop since the last one, OutOfTime where a deadline
    has passed, and what a question of `asking` raises."""
    check_signals()
    question, at = _question.get(), _until.get()
    if question is not None:
        question()
    if at is not None and time.monotonic() > at:
        raise OutOfTime


def check_signals() -> None:
    """A safe point for signals alone. Raises Interrupted."""
    if _requests is not None and _requests.pending:
        _requests.pending = False
        raise Interrupted


def signals() -> int:
    """How many signals have asked to stop so far."""
    return 0 if _requests is None else _requests.received


@contextmanager
def deadline(at: float | None) -> Iterator[None]:
    """Let `check` raise OutOfTime once the clock of `time.monotonic` is past a time [s]; None: never."""
    token = _until.set(at)
    try:
        yield
    finally:
        _until.reset(token)


def until() -> float | None:
    """The deadline in force, None without one."""
    return _until.get()


@contextmanager
def winding_up() -> Iterator[None]:
    """What an interrupted computation does to keep what it has reached. Raises Interrupted, which then ends the program
    without a result, at the first safe point after WIND_UP seconds of work: on a busy machine a person waits longer."""
    at, outer = time.process_time() + WIND_UP, _question.get()

    def question() -> None:
        if outer is not None:
            outer()
        if time.process_time() > at:
            raise Interrupted

    with asking(question):
        yield


@contextmanager
def asking(question: Callable[[], None]) -> Iterator[None]:
    """Let `check` ask a question besides, which raises where the work is to stop."""
    token = _question.set(question)
    try:
        yield
    finally:
        _question.reset(token)


@contextmanager
def interruptible(*, last: bool = False) -> Iterator[None]:
    """Let SIGINT and SIGTERM set the flag that `check` asks for.

    last : the process ends afterwards, and a signal that arrives while it does changes its exit code no more. A signal
    that the caller's shell has switched off stays so. Without effect inside another, and in a thread that may
    not handle signals.
    """
    global _requests
    if _requests is not None or threading.current_thread() is not threading.main_thread():
        yield
        return
    former = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    _requests = _Requests()
    try:
        for number, handler in former.items():
            if handler not in (signal.SIG_IGN, None):
                signal.signal(number, _receive)
        yield
    finally:
        for number, handler in former.items():
            if handler not in (signal.SIG_IGN, None):
                signal.signal(number, signal.SIG_IGN if last else handler)
        _requests = None


@contextmanager
def blocking() -> Iterator[None]:
    """Around a call that may wait for somebody else, such as a write to a pipe: here a signal raises at once."""
    check()
    requests = _requests
    if requests is None:
        yield
        return
    requests.blocking += 1
    try:
        yield
    finally:
        requests.blocking -= 1


def _receive(number: int, frame: FrameType | None) -> None:
    requests = _requests
    if requests is None:
        return
    requests.received += 1
    if requests.received > 1:
        _end()
    if requests.blocking:
        raise Interrupted
    requests.pending = True


def _end() -> None:
    """End the process without further ado."""
    if os.isatty(2):
        os.write(2, SHOW_CURSOR)
    os._exit(INTERRUPTED)
