"""Independent tasks on several cores: `working` tells how many processes there may be, `each` and `ahead` have tasks
done.

A task is a pure function at the top of a module, of one object that all tasks of a call share and of an item of its
own. Its result is the same in whatever process and order it runs: linear algebra works on one thread everywhere, and a
task in this process gets its arrays as pickling leaves them, contiguous and not to be written to, because the last bit
of a scalar product depends on how its factors lie in memory.

Processes are started once the work at hand takes longer than they take to start, and stay until the block of `working`
ends. There is one less than may work, for this process does not only wait: it does what it asks for where that is not
begun, and what comes next while another is at it. What tasks share is written to a file once and mapped into the memory
of each process; a large result comes back the same way. A process ends by itself when this one has gone, leaves
keyboard interrupts to it, and abandons a task whose result is no longer wanted.
"""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from robotid.interrupt import Interrupted, OutOfTime, asking, check_signals, deadline, signals, until

if TYPE_CHECKING:
    from concurrent.futures import Future

    from loky import ProcessPoolExecutor

Item = TypeVar("Item")
Result = TypeVar("Result")

START_UP = 1.5  # [s] of work that starting processes is worth: what they take to import the simulator
HAND_OVER = 0.02  # [s] of work that is not worth a message to a process
SECONDS_PER_SAMPLE = 2e-5  # of a fit, about: what is known of a task before it has run
POLL = 0.02  # [s] between two questions whether a result is there
WATCH = 0.2  # [s] between two questions of a process whether it is still needed
GRACE = 3.0  # [s] in which a process that is not needed any more may end a task
LARGE = 1 << 20  # bytes of arrays in a result, from which a file is faster than a pipe
ALIGNMENT = 64  # bytes, of arrays in a mapped file
SIMULATOR = "robotid.estimate.grey_box"  # by name, for this room lies below it
VARIABLES = ("OPENBLAS", "OMP", "MKL", "BLIS", "VECLIB_MAXIMUM")
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in VARIABLES}
"""Variables of the environment that hold linear algebra to one thread in a process that has yet to import it."""

Event = Callable[[Any], None]
"""Is called with what a task reports while it works."""


class _Unwanted(BaseException):
    """The result of a task is no longer wanted."""


@contextmanager
def working(jobs: int | None = None) -> Iterator[None]:
    """Within this block `each` and `ahead` use so many processes, None: as many as there are cores. Without effect
    inside another."""
    if _crew.get() is not None:
        yield
        return
    crew = _Crew(_cores() if jobs is None else jobs)
    token = _crew.set(crew)
    try:
        yield
    finally:
        _crew.reset(token)
        crew.dismiss()


@contextmanager
def one_thread() -> Iterator[None]:
    """Within this block linear algebra uses one thread: on matrices as small as those of a joint others only cost time,
    and they change the last bit of sums."""
    import scipy.linalg  # noqa: F401  it brings a library of its own, which is limited only once it is there

    try:
        from threadpoolctl import threadpool_limits
    except ImportError:  # the command line has set the environment; elsewhere the last bits are those of its threads
        yield
        return
    with threadpool_limits(limits=1, user_api="blas"):
        yield


@contextmanager
def computing(jobs: int | None = 1) -> Iterator[None]:
    """Both: so many processes, and one thread of linear algebra in each."""
    with one_thread(), working(jobs):
        yield


def each(
    task: Callable[..., Result],
    shared: Any,
    items: Sequence[Item],
    *,
    samples: int,
    log: Event | None = None,
) -> list[Result]:
    """The results of task(shared, item) of all items. Arguments and errors as of `ahead`."""
    with ahead(task, shared, items, samples=samples, log=log) as results:
        return list(results)


@contextmanager
def ahead(
    task: Callable[..., Result],
    shared: Any,
    items: Sequence[Item],
    *,
    samples: int,
    log: Event | None = None,
    hands_on_interrupts: bool = False,
) -> Iterator[Sequence[Result]]:
    """The results of task(shared, item), each there when it is asked for: other processes work ahead, this one works
    when asked. What is not asked for within the block is dropped.

    samples : over which a task runs, to tell whether it is worth a process. log : what tasks report; they are called
    with it as log=, and reports arrive in the order in which results are asked for. hands_on_interrupts : an interrupt
    goes to the tasks, which end early; else it ends the wait.

    Raises, when a result is asked for, what its task raised.
    """
    crew, seconds = _crew.get(), samples * len(items) * SECONDS_PER_SAMPLE
    pool = None if crew is None or len(items) < 2 else crew.pool(seconds)
    if pool is not None:
        with pool.call(_Work(task, items, log, hands_on_interrupts), shared) as results:
            if results is not None:
                yield results
                return
    yield _OneByOne(task, _as_sent(shared), items, log, crew)


def workers() -> int:
    """How many processes there may be here."""
    crew = _crew.get()
    return 1 if crew is None else crew.jobs


def expect(samples: int) -> None:
    """Fits over so many samples are about to come, one after the other and several at a time: processes that are worth
    their start begin it now."""
    crew = _crew.get()
    if crew is not None:
        crew.pool(samples * SECONDS_PER_SAMPLE)


def _cores() -> int:
    with suppress(AttributeError):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(slots=True, eq=False)
class _Crew:
    """How many processes there may be, the seconds that tasks have taken in this one, and the pool once it is
    started. broken : a process has died, so that all work is done here."""

    jobs: int
    spent: float = 0.0
    started: _Pool | None = None
    broken: bool = False

    def pool(self, seconds: float) -> _Pool | None:
        """The processes that work which takes about so long is worth; while they start, short work is done here."""
        if self.jobs < 2 or self.broken or seconds < HAND_OVER:
            return None
        if self.started is None and self.spent + seconds > START_UP:
            try:
                self.started = _Pool(self)
            except (ImportError, OSError):  # a system without semaphores or shared folders: one process will do
                self.broken = True
        return self.started

    def dismiss(self) -> None:
        """End the processes."""
        if self.started is not None:
            self.started.close()


_crew: ContextVar[_Crew | None] = ContextVar("robotid.parallel", default=None)
"""None where nothing is `working`: a task is far below those who know how many processes are wanted."""


class _Lazily(Sequence[Result]):
    """Results by number."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._known: dict[int, Result] = {}

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, k: int) -> Result: ...
    @overload
    def __getitem__(self, k: slice) -> Sequence[Result]: ...
    def __getitem__(self, k: int | slice) -> Result | Sequence[Result]:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(self._count))]
        if not 0 <= k < self._count:
            raise IndexError(k)
        if k not in self._known:
            self._known[k] = self._result(k)
        found: Result = self._known[k]
        return found

    def _result(self, k: int) -> Result:
        raise NotImplementedError


class _OneByOne(_Lazily[Result], Generic[Item, Result]):
    """Results of this process."""

    def __init__(
        self, task: Callable[..., Result], shared: Any, items: Sequence[Item], log: Event | None, crew: _Crew | None
    ) -> None:
        super().__init__(len(items))
        self._task = task if log is None else partial(task, log=log)
        self._shared, self._items, self._crew = shared, items, crew

    def _result(self, k: int) -> Result:
        begin = time.perf_counter()
        found: Result = _as_sent(self._task(self._shared, _as_sent(self._items[k])))
        if self._crew is not None:
            self._crew.spent += time.perf_counter() - begin
        return found


@dataclass(frozen=True, slots=True, eq=False)
class _Work(Generic[Item, Result]):
    """A task and its items; the rest as of `ahead`."""

    task: Callable[..., Result]
    items: Sequence[Item]
    log: Event | None
    hands_on_interrupts: bool


@dataclass(slots=True, eq=False)
class _Pool:
    """Processes and the folder that they share with this one."""

    crew: _Crew
    folder: Path = field(init=False)
    executor: ProcessPoolExecutor = field(init=False)
    first: Future[None] = field(init=False)
    calls: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        from loky import ProcessPoolExecutor

        self.folder = Path(tempfile.mkdtemp(prefix="robotid-"))
        try:
            self.executor = ProcessPoolExecutor(
                self.others, initializer=_begin, initargs=(os.getpid(), str(self.folder)), env=ONE_THREAD
            )
            self.first = self.submit(_nothing)  # processes start at the first task
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

    @contextmanager
    def call(self, work: _Work[Item, Result], shared: Any) -> Iterator[Sequence[Result] | None]:
        """Results of the processes and of this one; None where there is no room for what they share."""
        self.calls += 1
        file = self.folder / f"{self.calls}"
        try:
            _write(file, shared)
        except OSError:
            self.crew.broken = True
            yield None
            return
        results = _Together(self, file, work)
        try:
            yield results
        finally:
            results.drop()

    def close(self) -> None:
        """End the processes: those that still work notice that their folder has gone."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.executor.shutdown(wait=True)


class _Together(_Lazily[Result], Generic[Item, Result]):
    """Results of other processes and of this one. Others begin with what is asked for after the first, which this one
    will do. file : of what the tasks share."""

    def __init__(self, pool: _Pool, file: Path, work: _Work[Item, Result]) -> None:
        super().__init__(len(work.items))
        self._pool, self._file, self._work = pool, file, work
        self._here = _OneByOne(work.task, _read(str(file)), work.items, work.log, _Crew(1))
        self._failed: dict[int, BaseException] = {}
        self._lock = threading.Lock()
        self._waiting = [*range(1, len(work.items)), 0]
        self._futures: dict[int, Future[Result]] = {}
        self._until = until()
        for _ in range(pool.others):  # at once, or as soon as they have started
            pool.first.add_done_callback(self._feed)

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

    def _feed(self, _: Future[Any]) -> None:
        """Have a process that is free do what comes next. Is called in a thread of its library, too."""
        with self._lock:
            if not self._waiting or self._pool.crew.broken:
                return
            k = self._waiting[0]
            work, results = self._work, str(self._results(k))
            reports = None if work.log is None else str(self._reports(k))
            asked = _Asked(work.task, str(self._file), work.items[k], results, reports, self._until)
            try:
                future = self._pool.submit(_serve, asked)
            except RuntimeError:  # its processes have ended: all is done here
                self._pool.crew.broken = True
                return
            self._futures[self._waiting.pop(0)] = future
        future.add_done_callback(self._feed)

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
        before, token = signals(), _crew.set(_Crew(1))
        try:
            return self._here[k]
        finally:
            _crew.reset(token)
            if self._work.hands_on_interrupts and signals() > before:
                self._interrupted.touch()

    def _received(self, k: int, future: Future[Result]) -> Result:
        """The result of a process that is done with it, or has died over it: the rest is done here."""
        from concurrent.futures import CancelledError
        from concurrent.futures.process import BrokenProcessPool

        try:
            found = future.result()
            return _read(found.file) if isinstance(found, _Written) else found
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


# pickling ------------------------------------------------------------------------------------------------------------


def _as_sent(content: Any) -> Any:
    """An object as another process would receive it, its arrays contiguous; those that are so already are shared."""
    buffers: list[pickle.PickleBuffer] = []
    image = pickle.dumps(content, protocol=5, buffer_callback=buffers.append)
    return pickle.loads(image, buffers=[buffer.raw().toreadonly() for buffer in buffers])


def _write(file: Path, content: Any, least: int = 0) -> bool:
    """Write an object to a file that other processes map into their memory: a table of lengths, what is pickled, and
    the arrays. least : bytes of arrays, below which nothing is written. Returns whether it was."""
    buffers: list[pickle.PickleBuffer] = []
    image = pickle.dumps(content, protocol=5, buffer_callback=buffers.append)
    parts: list[Any] = [image, *(buffer.raw() for buffer in buffers)]
    if sum(map(len, parts[1:])) < least:
        return False
    table = pickle.dumps([len(part) for part in parts])
    with open(file, "wb") as stream:
        for part in (len(table).to_bytes(8, "little"), table, *parts):
            stream.write(bytes(-stream.tell() % ALIGNMENT))
            stream.write(part)
    return True


def _read(file: str) -> Any:
    """The object that such a file holds; its arrays lie in the file."""
    with open(file, "rb") as stream:
        mapped = memoryview(mmap(stream.fileno(), 0, access=ACCESS_READ))
    at = 0

    def following(length: int) -> memoryview:
        nonlocal at
        at += -at % ALIGNMENT
        found = mapped[at : at + length]
        at += length
        return found

    table = following(int.from_bytes(following(8), "little"))
    image, *buffers = [following(length) for length in pickle.loads(table)]
    return pickle.loads(image, buffers=buffers)


# in another process --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """A task that is asked of a process. file : what it shares with others; result : where it may leave its own;
    reports : where its reports go; until : the deadline."""

    task: Callable[..., Any]
    file: str
    item: Any
    result: str
    reports: str | None
    until: float | None


@dataclass(frozen=True, slots=True)
class _Written:
    """A result that lies in a file."""

    file: str


_shared: dict[str, Any] = {}
"""The last shared object of a process, by its file: the next task asks for the same."""


def _serve(asked: _Asked) -> Any:
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
        _shared[asked.file] = _read(asked.file)
    with asking(still_wanted), deadline(asked.until), working(1):
        if asked.reports is None:
            return _returned(asked, asked.task(_shared[asked.file], asked.item))
        with open(asked.reports, "ab") as stream:
            return _returned(asked, asked.task(_shared[asked.file], asked.item, log=partial(_report, stream)))


def _returned(asked: _Asked, result: Any) -> Any:
    """A result as it is handed back: in a file where it is large, if there is room for one."""
    file = Path(asked.result)
    try:
        return _Written(asked.result) if _write(file, result, LARGE) else result
    except OSError:
        file.unlink(missing_ok=True)
        return result


def _report(stream: Any, event: Any) -> None:
    stream.write(pickle.dumps(event))
    stream.flush()


def _nothing() -> None:
    pass


def _begin(parent: int, folder: str) -> None:
    """Prepare a process: an interrupt concerns its parent, and where that has gone it ends. What every fit needs is
    imported while the parent still prepares the first task."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_watch, args=(parent, Path(folder)), name="watch", daemon=True).start()
    import_module(SIMULATOR)


def _watch(parent: int, folder: Path) -> None:
    """End the process once its parent has gone, or once the work is over and it does not end by itself."""
    while folder.exists() and os.getppid() == parent:
        time.sleep(WATCH)
    if os.getppid() == parent:
        time.sleep(GRACE)
    os._exit(0)
