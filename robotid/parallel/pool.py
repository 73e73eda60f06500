"""Processes beside this one, and the results of tasks that both work out."""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic

from robotid.interrupt import Interrupted, OutOfTime, check_signals, signals, until
from robotid.parallel.crew import Crew, crew_here
from robotid.parallel.process import POLL, Asked, Written, begin, nothing, serve
from robotid.parallel.results import Event, Item, Lazily, OneByOne, Result
from robotid.parallel.sending import read, write
from robotid.parallel.threads import ONE_THREAD

if TYPE_CHECKING:
    from concurrent.futures import Future

    from loky import ProcessPoolExecutor

START_UP = 1.5  # [s] of work that starting processes is worth: what they take to import what this one has
PACKAGE = f"{__name__.partition('.')[0]}."  # of which a process imports what this one has
HAND_OVER = 0.02  # [s] of work that is not worth a message to a process


def pool_of(crew: Crew, seconds: float) -> Pool | None:
    """The processes that work which takes about so long is worth; while they start, short work is done here."""
    if crew.jobs < 2 or crew.broken or seconds < HAND_OVER:
        return None
    if crew.started is None and crew.spent + seconds > START_UP:
        try:
            crew.started = Pool(crew)
        except (ImportError, OSError):  # a system without semaphores or shared folders: one process will do
            crew.broken = True
    return crew.started


@dataclass(frozen=True, slots=True, eq=False)
class Work(Generic[Item, Result]):
    """A task and its items; the rest as of `ahead`."""

    task: Callable[..., Result]
    items: Sequence[Item]
    log: Event | None
    hands_on_interrupts: bool


@dataclass(slots=True, eq=False)
class Pool:
    """Processes and the folder that they share with this one."""

    crew: Crew
    folder: Path = field(init=False)
    executor: ProcessPoolExecutor = field(init=False)
    calls: int = field(default=0, init=False)
    _open: list[Together[Any, Any]] = field(default_factory=list, init=False)
    _idle: int = field(default=0, init=False)
    _lock: threading.RLock = field(default_factory=threading.RLock, init=False)

    def __post_init__(self) -> None:
        from loky import ProcessPoolExecutor

        self.folder = Path(tempfile.mkdtemp(prefix="robotid-"))
        try:
            known = [name for name in sys.modules if name.startswith(PACKAGE)]
            self.executor = ProcessPoolExecutor(
                self.others, initializer=begin, initargs=(os.getpid(), str(self.folder), known), env=ONE_THREAD
            )
            self.submit(nothing).add_done_callback(self._started)  # processes start at the first task
        except BaseException:
            shutil.rmtree(self.folder, ignore_errors=True)
            raise

    @property
    def others(self) -> int:
        """How many processes there are besides this one."""
        return self.crew.jobs - 1

    def submit(self, task: Callable[..., Result], *arguments: Any) -> Future[Result]:
        """Have a process do a task."""
        with _interrupts_blocked():
            future: Future[Result] = self.executor.submit(task, *arguments)
        return future

    def feed(self) -> None:
        """Have processes that are idle do what comes next in the call that was made last, for which this one waits
        first. Is called in a thread of their library, too."""
        with self._lock:
            while self._idle and not self.crew.broken:
                future = next((one for call in reversed(self._open) if (one := call.begun()) is not None), None)
                if future is None:
                    return
                self._idle -= 1
                future.add_done_callback(self._done)

    def _started(self, _: Future[None]) -> None:
        with self._lock:
            self._idle = self.others
        self.feed()

    def _done(self, _: Future[Any]) -> None:
        with self._lock:
            self._idle += 1
        self.feed()

    @contextmanager
    def call(self, work: Work[Item, Result], shared: Any) -> Iterator[Sequence[Result] | None]:
        """Results of the processes and of this one; None where there is no room for what they share."""
        self.calls += 1
        file = self.folder / f"{self.calls}"
        try:
            write(file, shared)
        except OSError:
            self.crew.broken = True
            yield None
            return
        results = Together(self, file, work)
        with self._lock:
            self._open.append(results)
        self.feed()
        try:
            yield results
        finally:
            with self._lock:
                self._open.remove(results)
            results.drop()

    def close(self) -> None:
        """End the processes: those that still work notice that their folder has gone."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.executor.shutdown(wait=True)


class Together(Lazily[Result], Generic[Item, Result]):
    """Results of other processes and of this one. Others begin with what is asked for after the first, which this one
    will do. file : of what the tasks share."""

    def __init__(self, pool: Pool, file: Path, work: Work[Item, Result]) -> None:
        super().__init__(len(work.items))
        self._pool, self._file, self._work = pool, file, work
        self._here = OneByOne(work.task, read(str(file)), work.items, work.log, Crew(1))
        self._failed: dict[int, BaseException] = {}
        self._lock = threading.Lock()
        self._waiting = [*range(1, len(work.items)), 0]
        self._futures: dict[int, Future[Result]] = {}
        self._until = until()

    def drop(self) -> None:
        """What has not been asked for is wanted no more."""
        with self._lock:
            self._waiting.clear()
        for future in self._futures.values():
            future.cancel()
        left = [path for k in self._futures for path in (self._reports(k), self._results(k))]
        for path in (self._file, *left, self._interrupted):
            with suppress(OSError):
                path.unlink(missing_ok=True)

    def _reports(self, k: int) -> Path:
        return Path(f"{self._file}-{k}")

    def _results(self, k: int) -> Path:
        return Path(f"{self._file}-{k}-result")

    @property
    def _interrupted(self) -> Path:
        return Path(f"{self._file}-interrupted")

    def begun(self) -> Future[Result] | None:
        """What comes next, as a process begins it, None where nothing is left to begin."""
        with self._lock:
            if not self._waiting:
                return None
            k = self._waiting[0]
            work, results = self._work, str(self._results(k))
            reports = None if work.log is None else str(self._reports(k))
            asked = Asked(work.task, str(self._file), work.items[k], results, reports, self._until)
            try:
                future = self._pool.submit(serve, asked)
            except RuntimeError:  # its processes have ended: all is done here
                self._pool.crew.broken = True
                return None
            self._futures[self._waiting.pop(0)] = future
            return future

    def _taken(self, k: int | None = None) -> int | None:
        """The number of a task that this process is to do: this one, or the next, None where it is begun."""
        with self._lock:
            found = next((j for j in self._waiting if k is None or j == k), None)
            if found is not None:
                self._waiting.remove(found)
            return found

    def _result(self, k: int) -> Result:
        if self._taken(k) is not None:
            return self._done_here(k)
        if k not in self._futures:
            if k in self._failed:
                raise self._failed[k]
            return self._here[k]
        future, reports = self._futures[k], _Reports(self._reports(k), self._work.log)
        while not future.done():
            try:
                check_signals()
            except Interrupted:
                if not self._work.hands_on_interrupts:
                    raise
                self._interrupted.touch()
            reports.read()
            self._wait(future)
        reports.read()
        return self._received(k, future)

    def _wait(self, future: Future[Result]) -> None:
        """Wait a little for what a process does, or do what comes next."""
        from concurrent.futures import wait

        following = self._taken() if self._work.log is None else None  # reports keep the order of the results
        if following is None:
            wait([future], timeout=POLL)
            return
        try:
            self._done_here(following)
        except (Exception, OutOfTime) as error:
            self._failed[following] = error

    def _done_here(self, k: int) -> Result:
        """The result of a task that this process does, as another would: without the others."""
        before, token = signals(), crew_here.set(Crew(1))
        try:
            return self._here[k]
        finally:
            crew_here.reset(token)
            if self._work.hands_on_interrupts and signals() > before:
                self._interrupted.touch()

    def _received(self, k: int, future: Future[Result]) -> Result:
        """The result of a process that is done with it, or has died over it: the rest is done here."""
        from concurrent.futures import CancelledError
        from concurrent.futures.process import BrokenProcessPool

        try:
            found = future.result()
            return read(found.file) if isinstance(found, Written) else found
        except (BrokenProcessPool, CancelledError):  # one was killed, for its memory perhaps
            self._pool.crew.broken = True
            return self._done_here(k)


@dataclass(slots=True, eq=False)
class _Reports:
    """What a task in another process has reported so far."""

    file: Path
    log: Event | None
    read_to: int = 0

    def read(self) -> None:
        """Hand on what is new, as far as it is whole."""
        if self.log is None or not self.file.exists():
            return
        with open(self.file, "rb") as stream:
            stream.seek(self.read_to)
            try:
                while True:
                    event = pickle.load(stream)
                    self.read_to = stream.tell()
                    self.log(event)
            except (EOFError, pickle.UnpicklingError):
                return


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Processes that begin in this block are born deaf to the keyboard: their parent decides what an interrupt ends."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # beginning with the first process, it would let interrupts through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
