"""Tasks in several processes: the same results, in the same order, and nothing that stays behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from support import tasks
from support.paths import ROOT

from robotid.errors import NumericsError
from robotid.interrupt import Interrupted, OutOfTime, check, deadline, interruptible
from robotid.parallel import ahead, each, one_thread, working
from robotid.parallel.process import LARGE

pytest.importorskip("loky", reason="processes need loky")
MUCH = 10_000_000  # samples: worth a process


@contextmanager
def both_working() -> Iterator[None]:
    """Two processes, of which the second has started."""
    with working(2):
        while len(set(each(tasks.process, None, range(2), samples=MUCH))) < 2:
            time.sleep(0.02)
        yield


def test_results_are_the_same_to_the_last_bit_wherever_arrays_lie() -> None:
    wide = np.random.default_rng(0).standard_normal((300, 400))
    found = []
    for shared in (wide.T[::3], np.ascontiguousarray(wide.T[::3])):
        for jobs in (1, 2):
            with working(jobs):
                found.append(each(tasks.square_sum, shared, [17, 50, 101, 133], samples=MUCH))
    assert found[1:] == found[:-1]


def test_work_is_done_elsewhere_only_where_it_is_worth_it(tmp_path: Path) -> None:
    with working(2):
        assert set(each(tasks.process, None, range(3), samples=1)) == {os.getpid()}
    with both_working():
        first, second = each(tasks.process_of_pair, str(tmp_path / "first"), range(2), samples=MUCH)
        assert first == os.getpid() != second
    with working(1):
        assert set(each(tasks.process, None, range(3), samples=MUCH)) == {os.getpid()}
    assert set(each(tasks.process, None, range(3), samples=MUCH)) == {os.getpid()}


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals are not blocked here")
def test_processes_are_born_deaf_to_the_keyboard_and_their_parent_is_not() -> None:
    script = (  # nothing has begun here: whoever starts what later processes share, must not undo it
        "from robotid.parallel import each, working\n"
        "from support.tasks import deaf\n"
        "found = [False, False]\n"
        "with working(2):\n"
        f"    while not found[1]: found = each(deaf, None, range(2), samples={MUCH})\n"
        "print(*found)"
    )
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests"), *sys.path])
    run = subprocess.run([sys.executable, "-c", script], env=os.environ | {"PYTHONPATH": path}, capture_output=True)
    assert run.stdout.split() == [b"False", b"True"]


def test_processes_start_once() -> None:
    with working(2):
        found = [each(tasks.process, None, range(4), samples=MUCH) for _ in range(3)]
    assert len({number for numbers in found for number in numbers}) <= 2


def test_one_process_needs_no_library() -> None:
    script = (
        "import sys\n"
        "from robotid.parallel import each, working\n"
        "from support.tasks import process\n"
        f"with working(1): each(process, None, range(3), samples={MUCH})\n"
        "print('loky' in sys.modules)"
    )
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests"), *sys.path])
    run = subprocess.run([sys.executable, "-c", script], env=os.environ | {"PYTHONPATH": path}, capture_output=True)
    assert run.stdout.split() == [b"False"]


def test_a_script_needs_no_guard(tmp_path: str) -> None:
    script = f"{tmp_path}/script.py"
    with open(script, "w", encoding="utf-8") as file:
        file.write(
            "from robotid.parallel import each, working\n"
            "from support.tasks import process\n"
            f"with working(2): print(len(set(each(process, None, range(3), samples={MUCH}))))\n"
        )
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests"), *sys.path])
    run = subprocess.run([sys.executable, script], env=os.environ | {"PYTHONPATH": path}, capture_output=True)
    assert run.stdout.split()[0] in (b"1", b"2")
    assert run.stderr == b""


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_comes_from_the_task_that_is_asked_for(jobs: int) -> None:
    with working(jobs), ahead(tasks.refused, None, [0, 1, 2], samples=MUCH) as found:
        assert (found[2], found[0]) == (2, 0)
        with pytest.raises(NumericsError) as error:
            found[1]
    assert str(error.value) == "here: 1 is odd; ask for another"


@pytest.mark.parametrize("jobs", [1, 2])
def test_reports_arrive_in_the_order_of_the_results(jobs: int) -> None:
    heard = list[int]()
    with working(jobs):
        assert each(tasks.reported, None, [1, 2, 3], samples=MUCH, log=heard.append) == [1, 2, 3]
    assert heard == [10, 11, 12, 20, 21, 22, 30, 31, 32]


def test_what_is_not_asked_for_is_abandoned() -> None:
    began = time.monotonic()
    with both_working():
        with ahead(tasks.endless, None, [0, 1, 2], samples=MUCH) as found:
            assert found[0] == 0
        assert each(tasks.process, None, [0, 1], samples=MUCH)
    assert time.monotonic() - began < 30


def test_one_task_is_done_elsewhere_while_this_process_does_something_else(tmp_path: Path) -> None:
    first = tmp_path / "first"
    with both_working(), ahead(tasks.process_of_pair, str(first), [0], samples=MUCH, meanwhile=True) as found:
        tasks.wait_for(first)
        assert found[0] != os.getpid()


def test_no_task_waits_for_a_process_that_is_at_another(tmp_path: Path) -> None:
    file = tmp_path / "begun"
    with (
        both_working(),
        deadline(time.monotonic() + 20.0),
        ahead(tasks.endless_once_begun, str(file), [1], samples=MUCH, meanwhile=True),
    ):
        tasks.wait_for(file)
        assert set(each(tasks.process, None, range(3), samples=MUCH)) == {os.getpid()}
    check()


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_deadline_reaches_every_process(jobs: int) -> None:
    with working(jobs), deadline(time.monotonic() + 0.5), ahead(tasks.endless, None, [0, 1], samples=MUCH) as found:
        assert found[0] == 0
        with pytest.raises(OutOfTime):
            found[1]
    check()


def test_an_interrupt_ends_the_wait() -> None:
    with interruptible(), both_working(), ahead(tasks.endless, None, [0, 1], samples=MUCH) as found:
        threading.Timer(0.5, signal.raise_signal, [signal.SIGTERM]).start()
        with pytest.raises(Interrupted):
            found[1]


@pytest.mark.parametrize("numbers", [[1, 2], [0, 1]], ids=["of what this process does", "of the wait"])
def test_an_interrupt_is_handed_on_where_tasks_end_early(numbers: list[int]) -> None:
    with (
        interruptible(),
        both_working(),
        ahead(tasks.endless, None, numbers, samples=MUCH, hands_on_interrupts=True) as found,
    ):
        threading.Timer(0.5, signal.raise_signal, [signal.SIGINT]).start()
        assert list(found) == [-number for number in numbers]


def test_an_error_of_what_was_done_ahead_comes_when_it_is_asked_for() -> None:
    with both_working(), ahead(tasks.refused, None, [0, 2, 1], samples=MUCH) as found:
        assert (found[1], found[0]) == (2, 0)
        with pytest.raises(NumericsError):
            found[2]


def test_work_goes_on_where_a_process_dies() -> None:
    with both_working():
        assert each(tasks.killed, os.getpid(), [1, 2, 3], samples=MUCH) == [1, 2, 3]
        assert set(each(tasks.process, None, range(3), samples=MUCH)) == {os.getpid()}


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_tasks_share_cannot_be_written_to(jobs: int) -> None:
    with working(jobs):
        assert each(tasks.written_to, np.zeros(100), range(2), samples=MUCH) == [False, False]


def test_large_results_come_whole_and_leave_no_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    wide = np.random.default_rng(1).standard_normal((300, 700))
    assert wide.nbytes > LARGE
    for jobs in (1, 2):
        with working(jobs) if jobs == 1 else both_working():
            found = each(tasks.scaled, wide, [1, 2, 3], samples=MUCH)
            assert not [path.name for path in tmp_path.rglob("*-result")]
        assert [name for name, _ in found] == ["times 1", "times 2", "times 3"]
        for factor, (_, values) in zip((1, 2, 3), found, strict=True):
            assert np.array_equal(values, (factor * wide).T)
            assert not values.flags.writeable
    assert not list(tmp_path.iterdir())


def test_a_large_result_comes_where_no_file_has_room() -> None:
    with both_working():
        found = each(tasks.scaled_on_a_full_disk, np.ones((300, 700)), [1, 2], samples=MUCH)
    assert [float(values.sum()) for _, values in found] == [210_000.0, 420_000.0]


def test_linear_algebra_uses_one_thread_here_and_there() -> None:
    threadpoolctl = pytest.importorskip("threadpoolctl")
    with threadpoolctl.threadpool_limits(2, user_api="blas"), one_thread():
        assert {library["num_threads"] for library in threadpoolctl.threadpool_info()} == {1}


def test_an_index_error_of_a_task_is_no_end_of_the_results() -> None:
    with pytest.raises(IndexError, match="of the task"):
        each(_out_of_range, None, [0, 1, 2], samples=1)


def _out_of_range(_: None, item: int) -> int:
    if item == 1:
        raise IndexError("of the task")
    return item
